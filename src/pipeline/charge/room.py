"""Memory for the samples of populations: used again when nobody reads it any more.

What the operating system hands out it clears first, page by page, which takes a tenth of a short charge's time.
"""

from __future__ import annotations

from queue import Empty, SimpleQueue

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LEAST, _MOST = 17, 21
"""Powers of two of the numbers that rooms which are kept have place for: 1 to 16 MiB."""
_KEPT = 4
"""Rooms of a size that are kept at most."""
_FREE: dict[int, SimpleQueue[Array]] = {power: SimpleQueue() for power in range(_LEAST, _MOST + 1)}


class _Loan:
    """A room as long as an array is a view of it; then it is free again."""

    def __init__(self, room: Array, power: int) -> None:
        self.room, self.power = room, power
        self.__array_interface__ = room.__array_interface__

    def __del__(self) -> None:
        # Collection comes at any moment, in any thread: this queue may be put into while it is taken from.
        if _FREE[self.power].qsize() < _KEPT:
            _FREE[self.power].put(self.room)


def room_for(rows: int, columns: int) -> Array:
    """Return an array (rows, columns) of whatever was there before."""
    size = rows * columns
    power = max(_LEAST, (size - 1).bit_length() if size else 0)
    if power > _MOST:
        return np.empty((rows, columns))
    try:
        room = _FREE[power].get_nowait()
    except Empty:
        room = np.empty(1 << power)
    return np.asarray(_Loan(room, power))[:size].reshape(rows, columns)
