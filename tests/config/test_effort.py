"""Effort is bounded when a run is planned: every count, grid, duration and interval, and sizes no plant has."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from pipeline.config.compose import Composed, compose_tree
from pipeline.config.effort import check_effort
from pipeline.config.planning import run_of
from pipeline.config.schema import schema
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.kernel import registry
from pipeline.kernel.draft import drafts
from pipeline.kernel.experiment import Effort
from pipeline.kernel.footprint import of_step

STUDIES = ("solar_reflex", "nicd_grnn", "lfp_cuckoo", "validation")
MANY = 999_999_937
# Numbers, not counts: the first cost nothing, and the last is itself a bound on a charge's effort.
NO_COUNTS = ("seed", "cells_in_series", "panels_in_series", "panels_in_parallel", "maximum_steps", "mode_repeat")


@cache
def composed(study: str) -> Composed:
    return compose_tree([f"study={study}"])


def counts(tree: Any, path: str = "") -> Iterator[str]:
    """Yield the key path of every whole number below a part of a configuration that steps compute with."""
    for key, value in tree.items() if isinstance(tree, dict) else ():
        here = f"{path}.{key}" if path else key
        if here.split(".")[0] in ("published", "figures") or key in ("sources", "limits", "elapsed_s", *NO_COUNTS):
            continue
        if type(value) is int:
            yield here
        yield from counts(value, here)


def changed(study: str, path: str, value: Any) -> Composed:
    """Return a study with a value overridden, without composing it again."""
    tree = deepcopy(composed(study).tree)
    *parents, last = path.split(".")
    here = tree
    for key in parents:
        here = here[key]
    here[last] = value
    return replace(composed(study), tree=tree, overrides=(f"study={study}", f"{path}={value}"))


def planned(one: Composed) -> None:
    study = study_from(one)
    check_effort(one, study, drafts(study))


EVERY = [(study, path) for study in STUDIES for path in counts(composed(study).tree)]


@pytest.mark.parametrize(("study", "path"), EVERY)
def test_no_count_is_taken_without_bound(study: str, path: str) -> None:
    with pytest.raises(UserError) as refused:
        planned(changed(study, path, MANY))
    assert str(refused.value).startswith((f"override {path}={MANY}: ", "conf/"))


@pytest.mark.parametrize("name", sorted(schema()["$defs"]))
def test_every_whole_number_of_the_schema_has_an_end(name: str) -> None:
    def ends(part: Any) -> bool:
        if isinstance(part, list):
            return all(map(ends, part))
        if not isinstance(part, dict):
            return True
        bounded = part.get("type") != "integer" or "maximum" in part or "exclusiveMaximum" in part
        return bounded and all(ends(one) for key, one in part.items() if key != "enum")

    assert ends(schema()["$defs"][name])


@pytest.mark.parametrize(
    ("study", "word", "told"),
    [
        (
            "nicd_grnn",
            "network.data.grid.temperatures=1e8",
            r"step surface would take about 410 GiB of memory; the limit is 2",
        ),
        ("solar_reflex", "search.particles=1e9", r"would take about .* GiB .* raise limits\.memory_gib"),
        ("solar_reflex", "search.iterations=1e11", "or less"),
        ("solar_reflex", "design.replicates=1e9", "step tuning would take"),
        ("solar_reflex", "chaos.bifurcation_steps=1e11", "or less"),
        ("solar_reflex", "chaos.disorder_steps=1e9", r"step chaos would take about .* h of .*raise limits\.hours"),
        ("solar_reflex", "oracle.refinements=1e9", "would take"),
        ("lfp_cuckoo", "functions.dimensions=1e6", "1000 or less"),
        ("lfp_cuckoo", "functions.variants.shared.generations=1e9", "would take"),
        ("nicd_grnn", "network.size.generations=1e12", "or less"),
        ("nicd_grnn", "network.selection.replicates=1e9", "step network would take"),
        ("nicd_grnn", "network.form.centres=6e6", "6000000 centres of 561 points; allowed is as many as there are"),
        ("nicd_grnn", "network.anfis.temperature_sets=1e6", "64 or less"),
        ("lfp_cuckoo", "staging.replicates=1e9", "step staging_search would take"),
        ("lfp_cuckoo", "staging.evaluations=1e12", "or less"),
        ("nicd_grnn", "trade_off.sensors.fast.sample_interval_s=1e-12", "0.001 or more"),
        ("nicd_grnn", "trade_off.sensors.fast.sample_interval_s=1e30", "86400 or less"),
        ("solar_reflex", "charge.sample_interval_s=1e30", "or less"),
        ("solar_reflex", "charge.windows=[{start_s: 0, length_s: 1e9}]", "step charge would take about"),
        ("solar_reflex", "engine.maximum_step_s=1e-12", "0.001 or more"),
        ("solar_reflex", "day.sample_interval_s=1e-9", "0.01 or more"),
        ("solar_reflex", "tracking.ramps.low_to_medium.slopes_w_m2_s=[1e-12]", "0.001 or more"),
        ("solar_reflex", "battery.thermal.heat_capacity_j_k=1e-30", "less than anything of its kind; allowed is 0.001"),
        ("solar_reflex", "battery.capacity_ah=7e9", "1000000 or less"),
        ("solar_reflex", "battery.series_resistance_ohm=1e21", "1000000000 or less"),
        ("solar_reflex", "objective.transistor.gate_voltage_v=1e300", "1000000 or less"),
        ("solar_reflex", "panel.max_power_w=1e40", "or less"),
        ("solar_reflex", "converter.switched.boost.inductance_h=1e-40", "less than anything of its kind"),
        ("solar_reflex", "limits.memory_gib=0", "more than 0"),
        ("solar_reflex", "limits.memory_gib=1e-4", "step .* would take about"),
        ("solar_reflex", "limits.hours=1e-6", "h of one core's time; the limit is 1e-06"),
    ],
)
def test_what_nobody_can_compute_or_build_is_refused(study: str, word: str, told: str) -> None:
    with pytest.raises(UserError, match=told) as refused:
        run_of([f"study={study}", word])
    assert str(refused.value).startswith((f"override {word}: ", "conf/" if word.startswith("limits") else "override"))


def test_limits_can_be_raised_and_change_no_key() -> None:
    plain, raised = run_of([]), run_of(["limits.memory_gib=64", "limits.hours=100"])
    assert raised.described() == plain.described()
    assert "limits" not in plain.configuration
    with pytest.raises(UserError, match=r"raise limits\.memory_gib"):
        run_of(["search.particles=100000"])
    run_of(["search.particles=100000", "limits.memory_gib=10000", "limits.hours=1000000"])


def test_a_step_that_a_limit_meets_says_so_in_every_study() -> None:
    """Every step whose effort can grow declares one; those that have none read no counts of their own."""
    without = {name for name, step in registry.steps().items() if of_step(step).effort is None}
    growing = {"charge", "ensemble", "search", "tuning", "chaos", "network", "network_size", "network_kernels", "front"}
    assert not without & (growing | {"staging_search", "staging", "function_runs", "trade_off", "tracking", "day"})


def test_an_effort_is_that_of_its_counts() -> None:
    study = study_from(composed("nicd_grnn"))
    (made,) = [one.effort for one in drafts(study) if one.step == "surface"]
    assert isinstance(made, Effort)
    larger = study_from(changed("nicd_grnn", "network.data.grid.gradients", 2 * study.network.data.grid.gradients))
    (twice,) = [one.effort for one in drafts(larger) if one.step == "surface"]
    assert twice is not None
    assert twice.memory_b == 2.0 * made.memory_b
