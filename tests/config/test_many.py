"""Runs of a sweep are composed and validated as each of them alone would be."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from pipeline.config.choices import parse
from pipeline.config.compose import CONF, compose_tree, options
from pipeline.config.many import Compositions, Memory, Unrefused
from pipeline.config.sections import Studies
from pipeline.config.sources import split
from pipeline.config.study import study_from
from pipeline.errors import UserError

# Key -> values of it that differ in kind; groups, plain values, lists, what others follow, references, left-out modes.
VALUES: dict[str, tuple[str, ...]] = {
    "battery": ("lead_acid_12v7ah", "lead_acid_12v18ah", "lead_acid_generic"),
    "weather": ("constant", "half_cloudy_taichung"),
    "modes.run": ("[cc_cv]", "[cv_reflex,cc_cv]", "[cv_pulse,cv_reflex,cc_cv]"),
    "modes.cv_reflex.frequency_hz": ("10", "12.5", "1e2", "{from:search,value:frequency_hz}"),
    "modes.cv_pulse.frequency_hz": ("20", "33.0"),
    "modes.cc_cv.max_current_a": ("1", "1.5"),
    "modes.cc_cv.stop": ("{elapsed_s:9000}",),
    "charge.initial_soc": ("0.1", "0.3", "0.25"),
    "charge.soc_marks": ("[0.5]", "[0.5,0.9]", "[]"),
    "charge.windows": ("[]",),
    "comparisons.same_mean.title": ("other", "'two words'"),
    "comparisons.same_mean.mean_current_of": ("cc_cv", "null", "${modes.run.0}"),
    "seed": ("1", "2"),
    "~day": ("",),
    "~battery@second_battery": ("",),
    "+figures.own": ("{draw:energy,title:T,caption:C}",),
    "panel.max_power_w": ("60", "60.5"),
}


def _sets(count: int) -> list[list[str]]:
    rng = np.random.default_rng(20150401)
    found = []
    for _ in range(count):
        keys = rng.choice(list(VALUES), size=int(rng.integers(1, 6)), replace=False)
        words = [(key, VALUES[key][int(rng.integers(len(VALUES[key])))]) for key in keys]
        found.append(["study=solar_reflex", *(f"{key}={value}" if value else key for key, value in words)])
    return found


@pytest.mark.parametrize(
    "count", [pytest.param(10, marks=pytest.mark.slow), pytest.param(200, marks=pytest.mark.struck)]
)
def test_random_sets_are_composed_as_hydra_does(count: int) -> None:
    modes = [f"+modes@modes.{name}={name}" for name in options("modes")]
    compositions = Compositions(Memory())
    for words in _sets(count):
        with initialize_config_dir(str(CONF), version_base="1.3"):
            whole = OmegaConf.to_container(compose("config", overrides=[*modes, *words]), resolve=True)
        assert isinstance(whole, dict)
        ours = compositions.compose(words).tree
        assert json.dumps(split(ours)[0]) == json.dumps(split(whole)[0]), words


def test_what_is_composed_of_many_is_what_is_composed_of_one() -> None:
    compositions = Compositions(Memory())
    for words in _sets(2):
        ours, alone = compositions.compose(words), compose_tree(words)
        assert json.dumps(ours.tree) == json.dumps(alone.tree), words
        assert ours.layers == alone.layers


def test_studies_of_many_runs_are_those_of_each_and_none_is_made_whole() -> None:
    memory = Memory()
    compositions, studies = Compositions(memory), Studies(memory)
    for frequency, battery in ((10, "lead_acid_12v7ah"), (20.5, "lead_acid_12v18ah"), (30, "lead_acid_12v7ah")):
        words = [f"battery={battery}", f"modes.cv_reflex.frequency_hz={frequency}"]
        ours = studies.of(compositions.compose(words))
    alone = study_from(compose_tree(words))
    assert studies.whole == 0
    for name in set(type(alone).model_fields) - {"sources", "overrides"}:
        assert getattr(ours, name) == getattr(alone, name), name


@pytest.mark.parametrize(
    "word",
    ["modes.cv_reflex.frequency_hz=-1", "modes.cc_cv.max_current_a=9000", "charge.initial_soc=0.995", "panel.cells=3"],
)
def test_what_a_run_alone_is_refused_for_it_is_refused_for_among_others(word: str) -> None:
    memory = Memory()
    compositions, studies = Compositions(memory), Studies(memory)
    studies.of(compositions.compose(["battery=lead_acid_12v7ah"]))
    with pytest.raises(UserError) as alone:
        study_from(compose_tree([word]))
    with pytest.raises(UserError) as among:
        studies.of(compositions.compose([word]))
    assert str(among.value) == str(alone.value)


def test_a_check_is_made_once_of_the_same_records_and_again_where_it_refused() -> None:
    seen: list[tuple[object, object]] = []
    allowed = [False]

    def check(one: object, other: object) -> None:
        seen.append((one, other))
        if not allowed[0]:
            raise UserError("refused")

    asked = Unrefused(check)
    one, other = [1], [2]
    for _ in range(2):
        with pytest.raises(UserError, match="refused"):
            asked(one, other)
    allowed[0] = True
    for _ in range(3):
        asked(one, other)
    asked(one, [2])
    # Equal records are not the same ones.
    assert len(seen) == 4
    assert seen[2][0] is one


def test_what_a_sweeps_word_sets_is_what_hydra_reads() -> None:
    compositions = Compositions(Memory())
    for key, values in VALUES.items():
        for value in values:
            word = f"{key}={value}" if value else key
            assert compositions.value(word) == parse([word])[0].value()
            assert compositions.value(word) == parse([word])[0].value()
