"""Found values: who may ask whom, and what happens to a name that is not there."""

from __future__ import annotations

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.sources import found_values
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.experiments.frequency.choices import searches, waveform
from pipeline.record import Reference

FREQUENCY = "modes.cv_reflex.frequency_hz"


def test_the_modes_ask_for_the_frequency_by_default():
    study = study_from(compose_tree([]))
    for mode in ("cv_reflex", "cv_pulse"):
        assert study.modes[mode].knobs["frequency_hz"] == Reference(source="search", value="frequency_hz")
        assert study.sources[f"modes.{mode}.frequency_hz"].kind == "found"
    assert study.search.c1 == Reference(source="tuning", value="c1")
    assert found_values(study) == {"search": ("frequency_hz",), "tuning": ("c1", "c2", "w")}


def test_a_number_reaches_the_modes_that_follow():
    study = study_from(compose_tree([f"{FREQUENCY}=50"]))
    assert [study.modes[mode].knobs["frequency_hz"] for mode in ("cv_reflex", "cv_pulse")] == [50, 50]
    assert study.sources[FREQUENCY].kind == "override"
    assert study.sources["modes.cv_pulse.frequency_hz"].kind == "derived"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([f"{FREQUENCY}={{from:serach,value:frequency_hz}}"], r"frequency_hz\.from: no step 'serach'.*search"),
        ([f"{FREQUENCY}={{from:search,value:frequency}}"], r"search finds no 'frequency'.*frequency_hz"),
        (["search.c1={from:tuning,value:c3}"], r"search\.c1\.value: tuning finds no 'c3'.*c1"),
        (["search.c1={from:search,value:frequency_hz}"], r"search\.c1\.from: 'search' would wait for itself"),
        (["objective.mode=cc_cv"], "objective.mode: 'cc_cv' has no pulses"),
        (["objective.mode=cv_refleks"], "no mode 'cv_refleks'.*cv_reflex"),
        (["search.kind=swram"], "no search algorithm 'swram'.*swarm"),
        (["search.variants.uniform.rand=chaos"], r"variants\.uniform\.rand.*chaos"),
        (["+design.factors.particles=[3,4]"], "design"),
        (["design.printed=solar_table9"], "design.printed: no table 'solar_table9'.*solar_table2"),
    ],
)
def test_a_mistake_is_named(words, message):
    with pytest.raises(UserError, match=message):
        study_from(compose_tree(words))


def test_a_reference_to_a_step_the_study_does_without_is_refused():
    with pytest.raises(UserError, match=r"search\.c1\.from: no step 'tuning'"):
        study_from(compose_tree(["~design"]))


def test_every_search_stands_under_its_name():
    found = searches(study_from(compose_tree([])))
    assert list(found) == ["swarm", "swarm_published", "published_protocol", "uniform", "arcsine", "sweep"]
    assert (found["swarm_published"].c1, found["swarm_published"].replicates) == (1.0, 200)
    assert found["uniform"].rand == "uniform"


def test_the_waveform_is_that_of_the_knobs():
    study = study_from(compose_tree(["modes.cv_reflex.discharge_share=0.04"]))
    found = waveform(study.modes["cv_reflex"], 7.0)
    assert found is not None
    assert (found.charge_a, found.charge_share, found.discharge_a, found.discharge_share) == (2.1, 0.9, 0.5, 0.04)
    assert waveform(study.modes["cc_cv"], 7.0) is None
