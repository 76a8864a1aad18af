"""Many charges at once: a population of parameter sets, protocols or conditions."""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Charge, Supply, simulate


class Task(NamedTuple):
    """One charge: the arguments of `simulate`."""

    battery: Battery
    mode: Mode
    supply: Supply
    settings: ChargeSettings
    engine: EngineSettings


def simulate_many(tasks: Iterable[Task], threads: int | None = None) -> list[Charge]:
    """Charge many batteries at once; each charge is, bit for bit, what `simulate` makes of it.

    The kernels let go of Python's lock, so threads run as many of them as there are cores. Whichever thread is free
    takes the next charge: a population is seldom of equal lengths, and its arrays never need to be of one shape.

    Arguments
    ---------
    tasks : the charges.
    threads : charges under way at once; as many as this process may use cores where not given.

    Returns
    -------
    The charges in the order of the tasks.

    Raises
    ------
    UserError, EngineError : as `simulate`, for the first charge that fails.
    """
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    with ThreadPoolExecutor(max_workers=threads or count) as pool:
        return list(pool.map(lambda task: simulate(*task), tasks))
