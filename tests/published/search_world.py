"""What the steps of a search could find: numbers under which every statement on it holds, and others."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tests import making
from tests.published.conftest import CONF, write_quantities

SEARCH_INPUTS = {"chaos", "objective", "tuning", "search", "reference/solar_table3"}
PRINTED_SUMS = np.array(
    [[58.4814, 59.0051, 58.9865], [56.1518, 56.0807, 57.5912], [60.53, 58.0469, 56.0805], [56.6622, 58.6927, 59.1672]]
)

AS_PUBLISHED_HERE: dict[str, Any] = {
    "chaos": {
        "distance_to_uniform": 0.002,
        "most_unstable_r": 4.0,
        **{f"most_disordered_r_{bins}_bins": 4.0 for bins in (10, 20, 100)},
    },
    "objective": {
        "ripple_and_switching_at_impedance_minimum_w": 0.030,
        "ripple_and_switching_at_classic_w": 0.030,
        "ripple_and_switching_at_optimum_w": 0.010,
        "mean_current_w": 0.25,
        "all_losses_at_classic_w": 0.3,
        "classic_warmer_k": 0.5,
        "classic_less_efficient_share": 0.004,
        "switching_energy_cv_pulse_j": 5e-6,
        "switching_energy_cv_reflex_j": 4e-6,
        "optimal_frequency_cv_pulse_hz": 90.0,
        "optimal_frequency_cv_reflex_hz": 90.0,
    },
    "tuning": {
        "published_chosen_c1": 1.0,
        "published_chosen_c2": 1.0,
        "published_chosen_w": 0.75,
        "published_combinations": 64.0,
        "published_runs": 16.0,
        "published_unbalanced": 0.0,
        "published_chosen_rank": 1.0,
        **{f"published_p_{name}": 0.01 for name in ("c1", "c2", "w")},
        **{f"rerun_share_{name}": 0.2 for name in ("c1", "c2", "w")},
    },
    "search": {
        "frequency_hz": 90.1,
        "ise_mw2_s": 0.21,
        "difference_from_sweep_hz": -0.01,
        "published_protocol_arrived_share": 1.0,
        "swarm_published_arrived_share": 0.99,
        "iterations_swarm_over_swarm_published_high": 0.45,
        "iterations_swarm_over_uniform_high": 0.45,
        "distance_swarm_over_uniform_high": 0.45,
        "iterations_swarm_over_arcsine_high": 0.45,
    },
    "best_mw2_s": 0.21,
    "chosen": {"c1": 2, "c2": 2, "w": 3},
    "rank": 1,
    "found_share": 0.8,
    "sums": PRINTED_SUMS + 2e-5,
}
OTHERWISE_HERE: dict[str, Any] = {
    "chaos": {
        "distance_to_uniform": 0.1,
        "most_unstable_r": 3.9,
        **{f"most_disordered_r_{bins}_bins": r for bins, r in ((10, 4.0), (20, 4.0), (100, 3.98))},
    },
    "objective": {
        "ripple_and_switching_at_impedance_minimum_w": 0.011,
        "ripple_and_switching_at_classic_w": 0.011,
        "ripple_and_switching_at_optimum_w": 0.010,
        "mean_current_w": 0.25,
        "all_losses_at_classic_w": 0.3,
        "classic_warmer_k": 0.01,
        "classic_less_efficient_share": 0.0002,
        "switching_energy_cv_pulse_j": 3e-6,
        "switching_energy_cv_reflex_j": 4e-6,
        "optimal_frequency_cv_pulse_hz": 100.0,
        "optimal_frequency_cv_reflex_hz": 90.0,
    },
    "tuning": {
        "published_chosen_c1": 1.0,
        "published_chosen_c2": 1.0,
        "published_chosen_w": 1.0,
        "published_combinations": 64.0,
        "published_runs": 32.0,
        "published_unbalanced": 1.0,
        "published_chosen_rank": 2.0,
        **{f"published_p_{name}": p for name, p in (("c1", 0.0), ("c2", 0.0), ("w", 0.1))},
        **{f"rerun_share_{name}": share for name, share in (("c1", 0.5), ("c2", 0.4), ("w", 0.01))},
    },
    "search": {
        "frequency_hz": 92.0,
        "ise_mw2_s": 0.3,
        "difference_from_sweep_hz": 0.2,
        "published_protocol_arrived_share": 0.8,
        "swarm_published_arrived_share": 0.99,
        "iterations_swarm_over_swarm_published_high": 0.51,
        "iterations_swarm_over_uniform_high": 0.51,
        "distance_swarm_over_uniform_high": 0.51,
        "iterations_swarm_over_arcsine_high": 0.51,
    },
    "best_mw2_s": 1.5,
    "chosen": {"c1": 2, "c2": 2, "w": 4},
    "rank": 2,
    "found_share": 0.5,
    "sums": PRINTED_SUMS + 1e-4,
}


def write_search(folders: Mapping[str, Path], printed: Path, world: Mapping[str, Any]) -> None:
    """Write what statements read of chaos, objective, tuning and search."""
    for step in ("chaos", "objective", "tuning", "search"):
        extra = {"published_best_mw2_s": world["best_mw2_s"]} if step == "tuning" else {}
        write_quantities(step, folders[step], world[step] | extra)
    table = (CONF / "reference" / "solar_table3.csv").read_text(encoding="utf-8")
    (printed / "solar_table3.csv").write_text(table, encoding="utf-8")
    write_sums(folders["tuning"], world["sums"])
    _write_levels(folders["tuning"], world["chosen"])
    _write_choice(folders["tuning"], world["rank"], world["found_share"])


def write_sums(folder: Path, sums: Any) -> None:
    """Write the sums by level, rows L1 to L4, columns C1, C2, W."""
    columns = {"level": np.arange(1, 5)} | dict(zip(("c1", "c2", "w"), np.asarray(sums).T, strict=True))
    making.output("tuning", folder).write("published_sums", columns)


def _write_levels(folder: Path, chosen: Mapping[str, int]) -> None:
    rows = [(name, level, level == best) for name, best in chosen.items() for level in range(1, 5)]
    columns = {
        "factor": [name for name, _, _ in rows],
        "level": [level for _, level, _ in rows],
        "setting": [float(level) for _, level, _ in rows],
        "sum": [57.0] * len(rows),
        "mean": [14.25] * len(rows),
        "signal_to_noise_db": [-22.9 if best else -23.2 for _, _, best in rows],
        "chosen": [best for _, _, best in rows],
    }
    making.output("tuning", folder).write("published_levels", columns)


def _write_choice(folder: Path, rank: int, found_share: float) -> None:
    factorial = {
        "c1": [1.0, 2.0],
        "c2": [1.0, 2.0],
        "w": [0.75, 1.0],
        "mean": [6.0, 6.1],
        "standard_deviation": [0.1, 0.1],
        "rank": [rank, 3 - rank],
        "in_array": [True, True],
    }
    output = making.output("tuning", folder)
    output.write("factorial", factorial)
    agreement: dict[str, Any] = {name: [0.5, 0.5] for name in output.columns("agreement")}
    agreement |= {"searches_per_run": [1, 5], "experiments": [50, 10], "found_share": [0.0, found_share]}
    output.write("agreement", agreement)
