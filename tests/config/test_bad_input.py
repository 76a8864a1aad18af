"""Bad input, one list: refused before anything runs, in one message that says what, where, and what is allowed."""

from __future__ import annotations

import re
from copy import deepcopy
from dataclasses import replace
from functools import cache

import pytest
import yaml

from pipeline.config.compose import Composed, compose_tree
from pipeline.config.study import study_from
from pipeline.errors import UserError

REFLEX = "modes.cv_reflex"
BULK = f"{REFLEX}.phases.bulk.until"
# A single phase that is over leaves nothing; one of several is skipped.
ONLY = "modes.cc_cv.phases.charge.until={{{}}}"

BATTERY = [
    ("battery.capacity_ah=-7", "capacity_ah: .*more than 0"),
    ("battery.capacity_ah=.nan", "capacity_ah: .*number"),
    ("battery.series_resistance_ohm=-0.01", "series_resistance_ohm is -0.01 ohm at SOC 0; it must be 0 or greater"),
    (
        "battery.series_resistance_ohm.polynomial=[0.004,-0.01]",
        "series_resistance_ohm is -0.006 ohm at SOC 0; it must be 0 or greater",
    ),
    ("battery.pairs.fast.resistance_ohm=-0.001", "pairs.fast.resistance_ohm is -0.001 ohm"),
    ("battery.pairs.fast.time_constant_s=0", "time_constant_s: .*more than 0"),
    ("battery.open_circuit_voltage_v=-2", "open_circuit_voltage_v is -2 V at SOC 0.5"),
    ("battery.open_circuit_voltage_v.polynomial=[2.15,0.5]", "open_circuit_voltage_v .*may not fall while charging"),
    ("battery.entropic_coefficient_v_k=5", "entropic_coefficient_v_k comes to 5 V/K; allowed is less than 0.00693 V/K"),
    ("battery.side_reaction.current_a=-1", "side_reaction.current_a: .*more than 0"),
    ("battery.thermal.heat_capacity_j_k=0", "heat_capacity_j_k: .*more than 0"),
    ("charge.ambient_c=-300", "ambient_c: .*-40 or more"),
    ("charge.initial_soc=1.2", "initial_soc: .*less than 1"),
]
ZERO_LENGTH = [
    (f"{BULK}.elapsed_s=0", r"bulk\.until\.elapsed_s: 0; it must be greater than 0"),
    (f"{BULK}.elapsed_s=1.0e-12", r"bulk\.until\.elapsed_s: 1e-12 s; allowed is 1e-06 s or more"),
    (ONLY.format("soc: 0.1"), r"charge\.until\.soc: 0.1 is met at the start, initial_soc 0.2; give more"),
    (ONLY.format("voltage_v: 9"), r"charge\.until\.voltage_v: 9 V is met at the start, .* rests at 12.08 V; give more"),
    (f"+{BULK}.current_a=5", r"bulk\.until\.current_a: 5 A, but the current is never above 2.1 A; give less"),
    (ONLY.format("temperature_c: 20"), r"charge\.until\.temperature_c: 20 degC is not above the ambient's 25"),
    ("modes.cc_cv.stop.elapsed_s=0", r"stop\.elapsed_s: 0; it must be greater than 0"),
    ("modes.cc_cv.stop.soc=0.1", r"stop\.soc: 0.1 is not above initial_soc 0.2"),
    ("modes.cc_cv.stop.temperature_c=20", r"stop\.temperature_c: 20 degC is not above the ambient's 25"),
    ("+modes.cc_cv.stop.voltage_v=9", r"stop\.voltage_v: 9 V is met at the start"),
    ("+modes.cc_cv.stop.current_a=3", r"stop\.current_a: 3 A, but the current is never above 2.1 A"),
    (f"{REFLEX}.charge_share=0", "charge_share: 0 is not a share of the period"),
    ("charge.windows=[{start_s: 0, length_s: 0}]", "length_s: .*more than 0"),
]
FREQUENCIES = [
    (f"{REFLEX}.frequency_hz=0", r"override modes.cv_reflex.frequency_hz=0: .*frequency_hz: 0; .*greater than 0"),
    (f"{REFLEX}.frequency_hz=3000", "3000 Hz; the shortest part of a pulse, .*up to 2500 Hz"),
    # A period no longer than a switching period of 20 us, and than two of them.
    (f"{REFLEX}.frequency_hz=50000", "50000 Hz"),
    (f"{REFLEX}.frequency_hz=25000", "25000 Hz; .*less than a switching period of 2e-05 s; allowed is up to 2500 Hz"),
    (f"{REFLEX}.frequency_hz=60000", "60000 Hz"),
]
WRONG_UNITS = [
    ("modes.cc_cv.voltage_v=14400", r"voltage_v: 14400 V .* rests at 12.89 V when full; allowed is 5.95 to 25.78 V"),
    ("modes.cc_cv.voltage_v=2.4", r"voltage_v: 2.4 V .* allowed is 5.95 to 25.78 V"),
    (f"{REFLEX}.voltage_v=144", r"bulk\.(limit\.)?voltage_v: 144 V .* allowed is 5.95 to 25.78 V"),
    ("+modes.cc_cv.stop.voltage_v=15000", r"stop\.voltage_v: 15000 V .* allowed is 5.95 to 25.78 V"),
    (f"{REFLEX}.charge_a=2100", r"charge_a: 2100 A is 300 C of 7 Ah; allowed is up to 100 C, 700 A"),
    ("modes.cc_cv.max_current_a=2100", r"max_current_a: 2100 A is 300 C of 7 Ah; allowed is up to 100 C, 700 A"),
]
FORMS = [
    ("modes.cc_cv.voltage_v=abc", "value 'abc' is none of its forms; allowed is a number or {from, value}$"),
    ("battery.series_resistance_ohm=abc", "value 'abc' is none of .* a number or {polynomial} or .* or {soc, value}$"),
    ("+battery.series_resistance_ohm.soc=[0,0.5,1]", "the keys polynomial, soc make none of its forms; allowed is a"),
    ("battery.series_resistance_ohm={soc: [0, 1], value: [1, 2]}", r"value \[1, 2\]; allowed is a list of 3 or more"),
    ("battery.pairs.fast=2", "value 2; allowed is a mapping, {resistance_ohm, time_constant_s}$"),
    ("trackers.constant_voltage.kind=Perturb_Observ", "kind is 'Perturb_Observ'; best matches are: perturb_observe"),
    ("trackers.constant_voltage={kind: constant_voltage}", r"gain: missing; share of the error in the voltage"),
    ("+modes.cc_cv.phases.charge.constant_voltage.foo=1", "constant_voltage.foo is no parameter .* max_current_a, "),
    ("modes.run=[CC_CV]", "no mode 'CC_CV' in conf/modes; best matches are: cc_cv,"),
]
ENGINE = [
    ("engine.driver=averged", "driver: .*'auto', 'edge' or 'averaged'"),
    ("engine.tolerance=0", "tolerance: .*more than 1e-13"),
    ("engine.maximum_step_s=0", "maximum_step_s: .*0.001 or more"),
    ("engine.maximum_steps=0", "maximum_steps: .*1 or more"),
]


@cache
def default() -> Composed:
    return compose_tree([])


def composed(word: str) -> Composed:
    """Return the default study with one value overridden, as Hydra would, composed once for all of them."""
    path, _, value = word.lstrip("+").partition("=")
    tree = deepcopy(default().tree)
    *parents, last = path.split(".")
    here = tree
    for key in parents:
        here = here[key]
    here[last] = yaml.safe_load(value)
    return replace(default(), tree=tree, overrides=(word,))


@pytest.mark.parametrize(("word", "message"), [*BATTERY, *ZERO_LENGTH, *FREQUENCIES, *WRONG_UNITS, *ENGINE, *FORMS])
def test_it_is_refused(word: str, message: str) -> None:
    with pytest.raises(UserError) as refused:
        study_from(composed(word))
    told = str(refused.value).splitlines()
    assert re.search(message, told[-1])
    for line in told:
        assert line.startswith((f"override {word}: ", "conf/battery/lead_acid_12v7ah.yaml:"))
    assert len(told) == 1 or "list of 3 or more" in message or "missing" in message


def test_what_is_not_overridden_is_not_refused() -> None:
    assert study_from(composed("charge.initial_soc=0.3")).charge.initial_soc == 0.3


@pytest.mark.parametrize("word", ["modes.cc_cv.voltage_v=24", "modes.cc_cv.max_current_a=70"])
def test_what_is_only_unusual_is_not_refused(word: str) -> None:
    study_from(composed(word))


def test_pulses_are_not_refused_where_there_is_one_part() -> None:
    study_from(compose_tree(["modes.cv_pulse.charge_share=1.0", "modes.run=[cc_cv,cv_pulse]"]))


def test_the_driver_can_be_forced() -> None:
    assert study_from(compose_tree(["engine.driver=averaged"])).engine.driver == "averaged"
