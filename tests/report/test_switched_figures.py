"""Figures and tables of the converters switch by switch, from made-up artefacts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline import quantity, schemas_switched, tables
from pipeline.report.draw import draw, module
from pipeline.report.records import FigureCard
from pipeline.report.switched_tables import switched_tables
from tests.report.conftest import cards

STEPS = {"cv_pulse": ("charge begins", "charge ends"), "cv_reflex": ("charge begins", "discharge begins")}


def write(folder: Path, pulses: bool = True) -> Path:
    folder.mkdir(parents=True)
    rows = {"periods": [], "waveform": [], "edges": [], "modes": []}
    for mode in ("cc_cv", *STEPS):
        place = {"comparison": "same_peak", "mode": mode, "window": 0}
        for number in range(50):
            rows["periods"].append(place | {"time_s": 5400.0 + 2e-5 * number})
        rows["modes"].append(place | {"pulses_hz": 90.0, "overshoot_a": 0.1})
        for edge, kind in enumerate(STEPS.get(mode, ()) if pulses else ()):
            for time_s in np.linspace(-1e-4, 6e-4, 40):
                rows["waveform"].append(place | {"edge": edge, "kind": kind, "time_s": time_s, "battery_a": 2.0})
    for (_, name), (file, table, *_) in schemas_switched.ARTEFACTS.items():
        if name == "quantities":
            columns = quantity.columns([quantity.Quantity("boost_duty", 0.3, "1", "duty")])
        else:
            names = [column.name for column in table.columns]
            columns = {key: [row.get(key, 0.5) for row in rows[name]] for key in names}
        tables.write(table, columns, folder / file)
    return folder


@pytest.mark.parametrize("pulses", [True, False])
@pytest.mark.parametrize("name", [name for name, card in cards().items() if "switched" in card.reads])
def test_it_draws(whole, tmp_path, name, pulses):
    data = replace(whole, inputs=whole.inputs | {"switched": write(tmp_path / "switched", pulses)})
    for path in draw(name, cards()[name], data, tmp_path):
        assert path.stat().st_size > 1000


def test_each_kind_of_step_has_its_field(whole, tmp_path):
    data = replace(whole, inputs=whole.inputs | {"switched": write(tmp_path / "switched")})
    card: FigureCard = cards()["figure_12_steps"]
    figure = module(card).draw(card, data)
    assert [axes.get_title() for axes in figure.axes if axes.axison] == [
        "Charge begins", "Charge ends", "Charge begins", "Discharge begins",
    ]  # fmt: skip


def test_the_tables_hold_every_row(whole, tmp_path):
    assert switched_tables(whole) == []
    data = replace(whole, inputs=whole.inputs | {"switched": write(tmp_path / "switched")})
    modes, boost = switched_tables(data)
    assert [row[1] for row in modes.rows] == ["CC-CV", "CV-pulse", "CV-Reflex"]
    assert boost.rows[0][:2] == ("boost_duty", 0.3)
