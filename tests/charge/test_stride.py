"""The weights of a stride by themselves: exact sums of quadratics, and the order of convergence."""

import numpy as np
import pytest

from pipeline.cell.relaxation import NODES
from pipeline.charge.stride import END, highest, move, new_stride, weigh


def stride_of(ratio, count, start):
    stride = new_stride()
    stride["parts"] = 1
    stride["ratio"][0], stride["before"][0] = ratio, start
    weigh(stride, count)
    return stride


@pytest.mark.parametrize("ratio", [0.0, 1e-9, 1e-4, 0.03, 0.7, 5.0, 60.0])
@pytest.mark.parametrize("count", [3, 17, 5400])
def test_what_is_quadratic_in_the_count_is_summed_exactly(ratio, count):
    def added(n):
        return 0.3 - 0.2 * (n / count) + 0.7 * (n / count) ** 2

    stride = stride_of(ratio, count, 0.4)
    stride["forcing"][:, 0] = added(NODES * count - 0.5)
    move(stride, END)
    value = 0.4
    for n in range(count):
        value = np.exp(-ratio) * value + added(n)
    assert stride["place"][END, 0] == pytest.approx(value, rel=1e-11)


@pytest.mark.parametrize("ratio", [0.0, 0.01])
def test_a_node_between_two_periods_keeps_to_the_map(ratio):
    count, start = 100, 0.4
    stride = stride_of(ratio, count, start)
    stride["forcing"][:, 0] = 0.2
    for j in range(3):
        move(stride, j)
        before = NODES[j] * count - 0.5
        sums = before if ratio == 0.0 else -np.expm1(-ratio * before) / -np.expm1(-ratio)
        assert stride["place"][j, 0] == pytest.approx(np.exp(-ratio * before) * start + 0.2 * sums, rel=1e-12)


def strides(number, periods):
    """Follow y -> y - y^2 / periods from 1 in so many strides."""
    value = 1.0
    for _ in range(number):
        stride = stride_of(0.0, periods // number, value)
        for _ in range(200):
            for j in range(3):
                move(stride, j)
            stride["forcing"][:, 0] = -(stride["place"][:3, 0] ** 2) / periods
        move(stride, END)
        value = stride["place"][END, 0]
    return value


def test_it_is_of_fifth_order():
    periods, exact = 1 << 20, 1.0
    for _ in range(periods):
        exact -= exact * exact / periods
    errors = np.array([abs(strides(number, periods) - exact) for number in (1, 2, 4)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(orders > 4.3)
    assert errors[-1] < 1e-7


def test_the_highest_value_may_lie_between_nodes():
    assert highest(*(1.0 - (NODES - 0.4) ** 2)) == pytest.approx(1.0, rel=1e-14)
    assert highest(*(NODES**2)) == 1.0
    assert highest(*(-NODES)) == pytest.approx(-NODES[0])
