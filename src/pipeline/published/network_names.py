"""Names a statement on a charger's network may use: the numbers its steps find."""

from __future__ import annotations

from typing import get_args

from pipeline.grnn.records import Kernel, Method, Surfaces

_SURFACE = "points temperatures gradients gradient_seconds legible_rows consistent_surfaces learnt_consistent"
_OF_A_SURFACE = ("variance", "rows_consistent", "largest_deviation", "consistent")
_NETWORK = (
    "points centres units units_of_all_data nodes_of_anfis rules_of_anfis population crossover mutation elite "
    "generations long_generations "
    "genetic_population_mean genetic_mse_long genetic_mse_median_long genetic_population_mean_long "
    "least_squares_linear_mse anfis_mse uncovered_share printed_temperatures printed_temperatures_selected"
)
_OF_A_METHOD = (
    "mse", "mse_median", "mse_mean", "mse_worst", "share_at_printed", "evaluations", "replicates",
    "width_temperature", "width_gradient",
)  # fmt: skip
_OF_A_SIZE = ("units", "mse", "mse_median", "forward_mse")


# More centres than this are no small network.
_MOST_CENTRES = 100


def network_quantities() -> dict[str, set[str]]:
    """Return step -> names of the numbers it could find, also by methods and for sizes that this run leaves out."""
    methods: tuple[str, ...] = get_args(Method)
    kernels: tuple[str, ...] = get_args(Kernel)
    surfaces, sizes = tuple(Surfaces.model_fields), range(1, _MOST_CENTRES + 1)
    return {
        "surface": set(_SURFACE.split()) | {f"{name}_{part}" for name in surfaces for part in _OF_A_SURFACE},
        "network": set(_NETWORK.split())
        | {f"{method}_{part}" for method in methods for part in _OF_A_METHOD}
        | {f"genetic_over_{method}{end}" for method in methods for end in ("", "_low", "_high")},
        "network_size": {"smallest_size_at_printed", "best_size", "forward_as_good_from"}
        | {f"size_{size}_{part}" for size in sizes for part in _OF_A_SIZE},
        "network_kernels": {
            f"{surface}_{kernel}_{part}" for surface in surfaces for kernel in kernels for part in ("mse", "mse_median")
        },
    }
