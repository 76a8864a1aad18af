"""Converters switch by switch: what cannot be is refused before anything runs."""

from __future__ import annotations

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.converter.records import BOOST
from pipeline.converter.switched import of_boost
from pipeline.errors import UserError
from pipeline.kernel.draft import drafts

BUCK = "converter.switched.buck"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["modes.cv_reflex.frequency_hz=3000"], r"modes\.cv_reflex\.frequency_hz: value 3000 Hz.*up to 2500 Hz"),
        (["modes.cv_pulse.frequency_hz=6000"], r"modes\.cv_pulse\.frequency_hz: value 6000 Hz.*up to 5000 Hz"),
        (["search.variables.frequency_hz.high=2600"], r"search\.variables\.frequency_hz\.high: value 2600 Hz.*2500"),
        ([f"{BUCK}.inductance_h=-1"], rf"{BUCK}\.inductance_h: value -1; allowed is more than 0"),
        ([f"{BUCK}.capacitor_resistance_ohm=0"], r"capacitor_resistance_ohm: .*more than 0"),
        ([f"{BUCK}.control.crossover_hz=9000"], r"crossover_hz is 9000 Hz.*up to 5000 Hz"),
        ([f"{BUCK}.control.zero_hz=2500"], r"zero_hz is 2500 Hz.*below crossover_hz, 2500 Hz"),
        ([f"{BUCK}.switching_frequency_hz=1000"], "switching_frequency_hz is 1000 Hz.*resonate at 590"),
        ([f"{BUCK}.rectifier=dioed"], "rectifier.*diode_emulated"),
        ([f"{BUCK}.inductence_h=1"], "no key 'inductence_h'.*inductance_h"),
        (["converter.switched.boost.input_capacitance_f=0"], "input_capacitance_f: .*more than 0"),
    ],
)
def test_a_mistake_is_named(words, message):
    with pytest.raises(UserError, match=message):
        study_from(compose_tree(words))


def test_a_slower_pulse_is_fine():
    study_from(compose_tree(["modes.cv_reflex.frequency_hz=2500"]))


def test_without_switches_there_is_no_node_and_no_limit():
    words = ["~converter.switched", "modes.cv_reflex.frequency_hz=3000"]
    assert "switched" not in {node.name for node in drafts(study_from(compose_tree(words)))}


def test_the_switches_change_no_charge():
    """The hours of a charge take the converters by their efficiencies, so that an inductor charges nothing again."""
    before, after = (
        {node.name: node.settings for node in drafts(study_from(compose_tree(words)))}
        for words in ([], [f"{BUCK}.inductance_h=330e-6"])
    )
    assert {name for name in before if before[name] != after[name]} == {
        *("switched", "converters", "page", "ensemble/switched"),
    }


def test_the_vocabulary_covers_the_numbers():
    study = study_from(compose_tree([]))
    switched = study.converter.switched
    found = of_boost(switched.boost, study.converter.bus_voltage_v, 17.4, 3.75, switched.samples_per_period)
    assert {one.name for one in found} == BOOST.names({})
