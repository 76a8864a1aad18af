"""Memory for samples is never two charges' at once, and used again once nobody reads it."""

import gc

import numpy as np
import pytest

from pipeline.charge import room
from pipeline.charge.room import room_for


@pytest.fixture(autouse=True)
def nothing_free():
    for free in room._FREE.values():
        while not free.empty():
            free.get_nowait()


def place(array):
    return array.__array_interface__["data"][0]


def test_what_is_still_read_is_not_handed_out_again():
    first = room_for(1000, 17)
    first[:] = 3.0
    row, at = first[7], place(first)
    del first
    second = room_for(1000, 17)
    second[:] = 5.0
    assert place(second) != at
    assert (row == 3.0).all()
    del row
    gc.collect()
    assert place(room_for(900, 17)) == at


def test_rooms_have_the_shape_that_is_asked_for_and_are_kept_apart_by_size():
    for rows in (0, 1, 7710, 7711, 123_361, 200_000):
        made = room_for(rows, 17)
        assert made.shape == (rows, 17)
        assert made.dtype == np.float64
        assert made.flags.c_contiguous
        assert made.flags.writeable
    small = place(room_for(10, 17))
    gc.collect()
    assert place(room_for(100_000, 17)) != small


def test_few_rooms_are_kept():
    held = [room_for(10, 17) for _ in range(9)]
    del held
    gc.collect()
    assert [free.qsize() for free in room._FREE.values()] == [4, 0, 0, 0, 0]
