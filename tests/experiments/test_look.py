"""One look for every figure: a palette told apart by everyone, true minus signs, and what looking finds in a figure."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from pipeline.report import style
from tests.experiments.looking import faults

# Machado, Oliveira and Fernandes 2009, "A physiologically-based model for simulation of color vision deficiency",
# severity 1: linear RGB as a person without one kind of cone sees it.
SEEN = {
    "all cones": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.119192, 0.9503041]]
)
WHITE = np.array([0.95047, 1.0, 1.08883])


def linear(colour: str) -> np.ndarray:
    shares = np.array([int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5)])
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def contrast_on_white(colour: str) -> float:
    """Return the contrast ratio of WCAG 2.2."""
    return 1.05 / (float(linear(colour) @ [0.2126, 0.7152, 0.0722]) + 0.05)


def lab(colour: str, kind: str) -> np.ndarray:
    """Return a colour in CIELAB as seen with a kind of colour vision."""
    share = TO_XYZ @ np.clip(np.asarray(SEEN[kind]) @ linear(colour), 0.0, 1.0) / WHITE
    x, y, z = np.where(share > (6 / 29) ** 3, np.cbrt(share), share / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def distance(one: str, other: str) -> float:
    """Return the least distance of two colours in CIELAB over all kinds of colour vision."""
    return min(float(np.linalg.norm(lab(one, kind) - lab(other, kind))) for kind in SEEN)


def test_contrast_and_distance_are_the_known_ones():
    assert contrast_on_white("#000000") == pytest.approx(21.0)
    assert contrast_on_white("#777777") == pytest.approx(4.48, abs=0.005)  # the example of WCAG's understanding 1.4.3
    assert lab("#ff0000", "all cones") == pytest.approx([53.24, 80.09, 67.20], abs=0.05)
    assert distance("#ffffff", "#000000") == pytest.approx(100.0, abs=0.1)
    assert distance("#004488", "#004488") == 0.0


@pytest.mark.parametrize("colour", [*(mark.colour for mark in style.MARKS), style.PUBLISHED, style.GREY, style.INK])
def test_every_line_stands_out_from_white(colour):
    assert contrast_on_white(colour) >= 3.0


def test_lines_are_told_apart_by_everyone():
    colours = [*(mark.colour for mark in style.MARKS), style.PUBLISHED]
    for one, other in itertools.combinations(colours, 2):
        assert distance(one, other) >= 15.0, (one, other)


def test_the_colour_of_published_values_is_no_other():
    others = [*(mark.colour for mark in style.MARKS), *(part.colour for part in style.PARTS), style.GREY, style.INK]
    assert min(distance(style.PUBLISHED, other) for other in others) >= 25.0


def test_parts_of_a_whole_are_told_apart_without_colour():
    assert len({part.hatch for part in style.PARTS}) == len(style.PARTS)
    for one, other in itertools.pairwise(style.PARTS):
        lightness = [lab(part.colour, "all cones")[0] for part in (one, other)]
        assert abs(lightness[0] - lightness[1]) >= 15.0, (one, other)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-0.5 A", "\N{MINUS SIGN}0.5 A"),
        ("from -.5 to -2", "from \N{MINUS SIGN}.5 to \N{MINUS SIGN}2"),
        ("e = best - X", "e = best \N{MINUS SIGN} X"),
        ("1e-14", "1e\N{MINUS SIGN}14"),
        ("CC-CV, 2015-06-21, no-2, half-cloudy", "CC-CV, 2015-06-21, no-2, half-cloudy"),
    ],
)
def test_a_hyphen_that_is_a_minus_becomes_one(text, expected):
    assert style.signed(text) == expected


def test_a_ratio_has_no_unit():
    assert [style.label("Efficiency", unit) for unit in ("1", "", "%")] == [
        "Efficiency",
        "Efficiency",
        "Efficiency [%]",
    ]


def test_names_at_the_ends_of_curves_keep_their_distance_and_order():
    axes = drawing_with(lambda axes: axes.set(xlim=(0, 1), ylim=(0, 1))).axes[0]
    style.at_ends(axes, [(0.5, "a", "#000000"), (0.49, "b", "#000000"), (0.9, "c", "#000000")], apart=0.1)
    heights = {text.get_text(): text.xy[1] for text in axes.texts}
    assert heights["a"] - heights["b"] == pytest.approx(0.1)
    assert (heights["a"] + heights["b"]) / 2 == pytest.approx(0.495)
    assert heights["c"] == pytest.approx(0.9)


def drawing_with(fill, height_in=3.0):
    with style.active():
        drawing = style.figure(height_in)
        fill(drawing.subplots())
    return drawing


def found_in(fill) -> list[str]:
    drawing = drawing_with(fill)
    with style.active():
        drawing.draw_without_rendering()
        return faults(drawing)


T = np.linspace(0.0, 1.0, 50)
BAD = {
    "has [1] for a unit": lambda axes: (axes.plot(T, T), axes.set_xlabel("Efficiency [1]")),
    "has a hyphen for a minus": lambda axes: (axes.plot(T, T), axes.set_xticks([0.5], ["-3 K"])),
    "cut by the edge": lambda axes: axes.figure.text(0.9, 0.2, "a long text that leaves the figure"),
    "lies over 'other'": lambda axes: [axes.text(0.5, 0.5, words) for words in ("one", "other")],
    "lies over the curve": lambda axes: (axes.plot(T, T), axes.text(0.5, 0.5, "words", ha="center", va="center")),
    "lies over 1 symbols": lambda axes: (axes.plot(0.5, 0.5, "o"), axes.text(0.5, 0.5, "words", ha="center")),
    "the legend ['a']": lambda axes: (axes.plot(T, 0.5 + 0 * T, label="a"), axes.legend(loc="center")),
    "is empty": lambda axes: None,
    "the curve 'a' lies beneath 'b'": lambda axes: [axes.plot(T, T, label=name) for name in "ab"],
    "1 of 1 symbols of 'a' lie beneath those of 'b'": lambda axes: [axes.plot(1, 1, "o", label=name) for name in "ab"],
    "runs over the edge of its box": lambda axes: box(axes, "many words in a box that is too narrow", 0.2),
}
GOOD = {
    "crossing curves": lambda axes: (axes.plot(T, T), axes.plot(T, 1 - T)),
    "a wide line under a dashed one": lambda axes: (axes.plot(T, T, linewidth=3), axes.plot(T, T, "--", linewidth=1)),
    "a small symbol upon a large one": lambda axes: [axes.plot(1, 1, "o", markersize=size) for size in (9, 5)],
    "words in a box": lambda axes: box(axes, "words", 0.6),
    "why nothing is drawn": lambda axes: style.nothing(axes, "no charge in this run"),
    "true minus": lambda axes: (axes.plot(T, -T), axes.set_title("\N{MINUS SIGN}3 K, CC-CV")),
}


def box(axes, words, width):
    from pipeline.report.circuit_parts import Circuit

    chart = Circuit(axes)
    chart.box((0.5, 0.5), width, 0.4, words)
    chart.done((0.0, 1.0), (0.0, 1.0))


@pytest.mark.parametrize("fault", list(BAD))
def test_looking_finds_the_fault(fault):
    assert any(fault in one for one in found_in(BAD[fault])), found_in(BAD[fault])


@pytest.mark.parametrize("what", list(GOOD))
def test_looking_finds_nothing_where_nothing_is_wrong(what):
    assert found_in(GOOD[what]) == []


@pytest.mark.parametrize("count", [1, 3, 7, 12])
@pytest.mark.parametrize("words", ["CC", "constant current, stopped by temperature", "W" * 60])
def test_a_legend_above_the_axes_is_as_wide_as_the_figure_allows(count, words):
    from matplotlib.lines import Line2D

    keys = [Line2D([], [], label=f"{words} {number}") for number in range(count)]
    drawing = drawing_with(lambda axes: (axes.plot(T, T), style.above(axes.figure, keys)), height_in=6.0)
    with style.active():
        assert faults(drawing) == []
