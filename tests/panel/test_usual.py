"""What a data sheet leaves out: usual values of the technology, with a range, that the model can be fitted to."""

import csv
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UserError
from pipeline.panel.database import FILES, LEFT_OUT, TECHNOLOGIES, completed
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import fit

# Sheets of five usual panels, without their coefficients and cells: title, W, V_mp, I_mp, V_oc, I_sc, cells.
SHEETS = [
    ("20 W, 12 V", 20.0, 17.5, 1.15, 21.6, 1.25, 36),
    ("100 W, 12 V", 100.0, 18.0, 5.56, 21.6, 5.96, 36),
    ("250 W, 60 cells", 250.0, 30.5, 8.2, 37.6, 8.7, 60),
    ("320 W, 72 cells", 320.0, 37.2, 8.6, 45.8, 9.1, 72),
    ("400 W, 108 half cells", 400.0, 31.0, 12.9, 37.2, 13.8, 60),
]


def sheet(title, power, v_mp, i_mp, v_oc, i_sc):
    return {
        "title": title,
        "max_power_w": power,
        "max_power_voltage_v": v_mp,
        "max_power_current_a": i_mp,
        "open_circuit_voltage_v": v_oc,
        "short_circuit_current_a": i_sc,
    }


@pytest.mark.parametrize("row", SHEETS, ids=lambda row: row[0])
def test_a_sheet_without_coefficients_and_cells_is_a_panel(row):
    made, sources = completed(sheet(*row[:6]))
    assert set(sources) == set(LEFT_OUT)
    for name, source in sources.items():
        assert source["kind"] == "estimate"
        assert source["range"][0] <= made[name] <= source["range"][1]
        assert "CEC database" in source["ref"]
    assert made["cells_in_series"] == row[6]
    panel = Panel.model_validate(made)
    found = maximum_power(panel, fit(panel), np.array([1000.0]), np.array([25.0])).max_power_w
    assert found[0] == pytest.approx(row[2] * row[3], rel=1e-6)


def test_what_is_given_stays(kc65t):
    given = kc65t.model_dump()
    assert completed(given) == (given, {})
    without = {key: value for key, value in given.items() if key != "beta_voc_v_per_k"}
    made, sources = completed({**without, "technology": "multi_silicon"})
    assert set(sources) == {"beta_voc_v_per_k"}
    assert made["beta_voc_v_per_k"] == pytest.approx(-0.0034 * 21.7)
    assert made["cells_in_series"] == 36


def test_an_unknown_technology_is_named():
    with pytest.raises(UserError, match=r"technology: value 'mono'; best matches are: mono_silicon"):
        completed({"technology": "mono"})


@pytest.mark.parametrize(
    ("name", "theirs"),
    [
        ("crystalline_silicon", ("Mono-c-Si", "Multi-c-Si")),
        ("mono_silicon", ("Mono-c-Si",)),
        ("multi_silicon", ("Multi-c-Si",)),
        ("cadmium_telluride", ("CdTe",)),
    ],
)
def test_the_values_are_those_of_the_database(name, theirs):
    path = Path(find_spec("pvlib").submodule_search_locations[0]) / "data" / FILES["cec"]
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file))
    rows = [dict(zip(lines[0], line, strict=True)) for line in lines[3:]]
    rows = [row for row in rows if row["Technology"] in theirs]

    def spread(values):
        return pytest.approx(np.percentile(np.array(values), [5, 50, 95]), rel=4e-3)

    usual = TECHNOLOGIES[name]
    assert usual.modules == len(rows)
    assert list(usual.isc) == spread([100 * float(row["alpha_sc"]) / float(row["I_sc_ref"]) for row in rows])
    assert list(usual.voc) == spread([100 * float(row["beta_oc"]) / float(row["V_oc_ref"]) for row in rows])
    assert list(usual.power) == spread([float(row["gamma_r"]) for row in rows])
    assert list(usual.cell_v) == spread([float(row["V_oc_ref"]) / float(row["N_s"]) for row in rows])
