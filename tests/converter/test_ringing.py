"""Overshoot, settling and ringing of answers that are known."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.converter.switched import edges

PERIOD_S = 1e-5


def answer(damping: float, count: int = 4000):
    """Return reference and current of a second-order system at 0 -> 2 A -> 0, sampled."""
    reference = np.concatenate([np.zeros(10), np.full(count, 2.0), np.zeros(10)])
    time = PERIOD_S * np.arange(count)
    omega, damped = 2e3, 2e3 * np.sqrt(1 - damping**2)
    decay = np.exp(-damping * omega * time)
    step = 2.0 * (1 - decay * (np.cos(damped * time) + damping * omega / damped * np.sin(damped * time)))
    current = np.concatenate([np.zeros(10), step, np.zeros(10)])
    return reference, current


@pytest.mark.parametrize("damping", [0.2, 0.4, 0.7])
def test_a_second_order_answer_has_its_overshoot(damping):
    (edge,) = edges(*answer(damping), PERIOD_S, 0.03)
    exact = 2.0 * np.exp(-np.pi * damping / np.sqrt(1 - damping**2))
    assert edge.kind == "charge begins"
    assert edge.overshoot_a == pytest.approx(exact, rel=1e-3)
    assert edge.settling_s == pytest.approx(-np.log(0.02 * np.sqrt(1 - damping**2)) / (damping * 2e3), rel=0.35)


def test_less_damping_rings_more():
    found = [edges(*answer(damping), PERIOD_S, 0.03)[0].ringing_j for damping in (0.2, 0.4, 0.7)]
    assert found[0] > found[1] > found[2] > 0


def test_an_answer_that_only_approaches_does_not_ring():
    reference = np.concatenate([np.full(5, 2.0), np.zeros(200), np.full(5, 2.0)])
    current = np.concatenate([np.full(5, 2.0), 2.0 * np.exp(-np.arange(1, 201) / 10), np.full(5, 2.0)])
    (edge,) = edges(reference, current, PERIOD_S, 0.03)
    assert (edge.overshoot_a, edge.ringing_j) == (0.0, 0.0)
    assert edge.deviation_j == pytest.approx(0.03 * PERIOD_S * np.sum((current - reference) ** 2))
    assert edge.settling_s == pytest.approx(PERIOD_S * np.ceil(10 * np.log(50) - 1e-9), abs=PERIOD_S)


def test_the_kinds_of_steps_and_the_one_cut_off():
    reference = np.concatenate([np.full(9, level) for level in (2.0, -0.5, 0.0, 2.0, 0.0)])
    found = edges(reference, reference, PERIOD_S, 0.03)
    assert [edge.kind for edge in found] == ["discharge begins", "discharge ends", "charge begins"]
    assert all(edge.overshoot_a == edge.ringing_j == edge.settling_s == 0.0 for edge in found)


def test_a_constant_current_has_no_steps():
    assert edges(np.full(50, 2.0), np.full(50, 2.0), PERIOD_S, 0.03) == []
