"""Curves for the explorer: few points that follow all that was recorded, in a script that any page can load."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pipeline.report.traces import MOST_POINTS, Trace, script, thinned


def test_a_short_curve_is_kept_whole() -> None:
    assert thinned(np.arange(5.0), [np.arange(5.0)]).tolist() == [0, 1, 2, 3, 4]


def test_straight_lines_need_their_corners_alone() -> None:
    time = np.arange(10_001.0)
    corner = np.minimum(time, 3000.0)
    assert thinned(time, [corner, 2.0 * time]).tolist() == [0, 3000, 10_000]


def test_a_spike_of_one_point_is_kept() -> None:
    time = np.arange(5000.0)
    spike = np.zeros(5000)
    spike[1234] = 1.0
    assert {1233, 1234, 1235} <= set(thinned(time, [np.sin(time / 300.0), spike]).tolist())


@pytest.mark.parametrize("most", [60, MOST_POINTS])
def test_lines_between_the_points_follow_the_curve(most: int) -> None:
    time = np.linspace(0.0, 10_000.0, 20_001)
    columns = [1.0 - np.exp(-time / 2000.0), np.where(time < 4000.0, 2.0, 2.0 * np.exp(-(time - 4000.0) / 900.0))]
    kept = thinned(time, columns, most)
    assert len(kept) <= most
    for column in columns:
        off = np.abs(np.interp(time, time[kept], column[kept]) - column).max()
        assert off < 1.5 * np.ptp(column) * (40.0 / most) ** 2 / 16.0


def test_the_script_gives_the_traces_to_the_page() -> None:
    trace = Trace("a/b", 'CC-CV "</script>', "peak", 1, np.array([0.0, 0.5]), {"Voltage [V]": np.array([2.0, 1 / 3])})
    text = script([trace])
    assert text.startswith("window.TRACES = ")
    assert "</script" not in text
    (found,) = json.loads(text.removeprefix("window.TRACES = ").rstrip(";\n"))
    assert (found["title"], found["time"]) == ('CC-CV "</script>', [0, 0.5])
    assert found["quantities"] == {"Voltage [V]": [2, 0.33333]}


def test_a_value_that_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match="JSON"):
        script([Trace("a", "A", "", 0, np.array([0.0, 1.0]), {"V": np.array([1.0, np.nan])})])
