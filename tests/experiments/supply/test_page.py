"""Table 1 of the solar paper on the page."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.experiments.supply import page
from pipeline.report.tables import Parameter, ReportData
from tests import making

PRINTED = "p_max_w,v_mp_v,i_mp_a,v_oc_v,i_sc_a\n60,17.4,3.75,21.7,3.99\n"


def test_table_1_sets_the_computed_beside_the_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = {
        "irradiance_w_m2": [200.0, 1000.0],
        "cell_temperature_c": [25.0, 25.0],
        "short_circuit_current_a": [0.8, 3.99],
        "open_circuit_voltage_v": [20.0, 21.7],
        "max_power_current_a": [0.75, 3.75],
        "max_power_voltage_v": [17.0, 17.4],
        "max_power_w": [12.75, 65.25],
    }
    making.output("panel", tmp_path / "panel").write("points", values)
    printed = tmp_path / "printed.csv"
    printed.write_text(PRINTED, encoding="utf-8")
    monkeypatch.setattr(page, "PRINTED", printed)
    rows = page.table_1(ReportData(making.inputs({"panel": tmp_path / "panel"}), {}, {})).rows
    assert rows[0] == ("maximum power", "W", 60.0, 65.25, pytest.approx(8.75))
    assert [row[4] for row in rows[1:]] == [0.0, 0.0, 0.0, 0.0]


def test_usual_values_and_the_file_of_the_weather_are_told(tmp_path: Path) -> None:
    making.output("supply", tmp_path / "supply").write("notes", {"note": ["taken for EPW, read by pvlib"]})
    sheet = Parameter("panel.max_power_w", 60.0, "W", "data_sheet", "label")
    usual = Parameter("panel.cells_in_series", 36, "", "estimate", "not given: usual for crystalline silicon", 34, 38)
    data = ReportData(making.inputs({"supply": tmp_path / "supply"}), {}, {}, parameters=[sheet, usual])
    assert page.files(data)[0].rows == (("taken for EPW, read by pvlib",),)
    (told,) = page.estimated(data)
    assert "panel.cells_in_series 36 (34 to 38)" in told
    assert "max_power_w" not in told
    assert page.estimated(ReportData(data.inputs, {}, {}, parameters=[sheet])) == []
