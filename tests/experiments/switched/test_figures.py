"""Figures and tables of the converters switch by switch, from made-up artefacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.converter.records import BOOST
from pipeline.experiments.switched import page
from pipeline.report.tables import ModeLabel, ReportData
from tests import making
from tests.experiments.drawing import cards, drawn, looked_at, saved

STEPS = {"cv_pulse": ("charge begins", "charge ends"), "cv_reflex": ("charge begins", "discharge begins")}


TITLES = ("CC-CV", "CV-pulse", "CV-Reflex")
MODES = {name: ModeLabel(title) for name, title in zip(("cc_cv", *STEPS), TITLES, strict=True)}


def write(folder: Path, pulses: bool = True) -> Path:
    output = making.output("switched", folder)
    rows = {"periods": [], "waveform": [], "edges": [], "modes": []}
    for mode in ("cc_cv", *STEPS):
        place = {"comparison": "same_peak", "mode": mode, "window": 0}
        for number in range(50):
            rows["periods"].append(place | {"time_s": 5400.0 + 2e-5 * number})
        rows["modes"].append(place | {"pulses_hz": 90.0, "overshoot_a": 0.1})
        for edge, kind in enumerate(STEPS.get(mode, ()) if pulses else ()):
            for time_s in np.linspace(-1e-4, 6e-4, 40):
                rows["waveform"].append(place | {"edge": edge, "kind": kind, "time_s": time_s, "battery_a": 2.0})
    for name, own in rows.items():
        output.write(name, {key: [row.get(key, 0.5) for row in own] for key in output.columns(name)})
    output.numbers([BOOST.quantity("boost_duty", 0.3)])
    return folder


def data_of(**folders: Path) -> ReportData:
    """Return a run of which the charges themselves are not read."""
    charges = {f"charge/same_peak/{mode}": Path() for mode in MODES}
    return ReportData(making.inputs(folders | charges), MODES, {"same_peak": "Same peak current"})


@pytest.mark.parametrize("pulses", [True, False])
@pytest.mark.parametrize("name", [name for name, card in cards().items() if card.draw == "switched_edges"])
def test_it_draws(tmp_path, name, pulses):
    data = data_of(switched=write(tmp_path / "switched", pulses))
    for path in saved(cards()[name], data, tmp_path):
        assert path.stat().st_size > 1000
    assert looked_at(cards()[name], data) == []


def test_each_kind_of_step_has_its_field(tmp_path):
    figure = drawn(cards()["figure_12_steps"], data_of(switched=write(tmp_path / "switched")))
    assert [axes.get_title(loc="left") for axes in figure.axes if axes.axison] == [
        "Charge begins", "Charge ends", "Charge begins", "Discharge begins",
    ]  # fmt: skip


def test_the_tables_hold_every_row(tmp_path):
    assert page.tables(data_of()) == []
    modes, boost = page.tables(data_of(switched=write(tmp_path / "switched")))
    assert [row[1] for row in modes.rows] == ["CC-CV", "CV-pulse", "CV-Reflex"]
    assert boost.rows[0][:2] == ("boost_duty", 0.3)
