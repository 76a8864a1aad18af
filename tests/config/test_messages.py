"""What a person is told: the override or the file first, what is meant, and no raw text of a library."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pipeline.commands.workflow import open_workflow
from pipeline.config.planning import run_of
from pipeline.errors import UserError


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("modes.cv_pulse.phases.bulk.constant_voltage=7", r"phases\.bulk: constant_voltage is 7; allowed is a mapping"),
        ("modes.cv_pulse.phases.bulk.constant_voltage=true", "constant_voltage is True; allowed is a mapping"),
        ("modes.grnn.title=7", r"modes\.grnn\.title: value 7; allowed is a text"),
        ("modes.plain_rule={from: search, value: nonesuch}", "modes.plain_rule has no key 'from'"),
        ("modes.cv_pulse.frequency_hz.from=1", "modes.cv_pulse.frequency_hz has no key 'from'"),
        ("day.weathers.clear.air=[1,2]", "a list and a mapping cannot be put together"),
        ("+configuration=5", "configuration: no part of a configuration that can be given"),
        ("+overrides=[a]", "overrides: no part of a configuration that can be given"),
        ("+run=[a]", "run: no part of a configuration that can be given"),
        ("+sources.x=1", r"sources\.x: no such value"),
        ("~modes", "Could not delete 'modes'"),
        ("battery.capacity=7", "battery has no key 'capacity'; best matches are: capacity_ah"),
        ("study.title=[" + "x," * 3000 + "x]", "allowed is a text"),
        ("+figures.energy_by_loss_path.comparison=nonesuch", r"no comparison 'nonesuch' in this run; known are: same_"),
        ("+figures.energy_by_loss_path.reads=[]", "reads: unknown key"),
        ("+figures.energy_by_loss_path.module=pipeline.experiments.x.figures.y", "module is found by the name"),
        (
            "+figures.x={draw: reflex_waveform, title: x, caption: x, options: {mode: nonesuch}}",
            "this run has no 'nonesuch'",
        ),
    ],
)
def test_messages_begin_with_the_override(words: str, told: str) -> None:
    with pytest.raises(UserError, match=told) as refused:
        run_of([words])
    message = str(refused.value)
    assert message.startswith(f"override {words.split('=')[0]}")
    assert len(message) < 2000
    assert not re.search("full_key|object_type|DictConfig|ListConfig", message)


def test_a_figure_may_not_ask_for_a_mode_that_nobody_has() -> None:
    with pytest.raises(UserError, match=r"^override figures.*options\.mode: this run has no 'nonesuch'; known are: "):
        run_of(["study=lfp_cuckoo", "figures.figure_7_temperature.options.mode=nonesuch"])


@pytest.mark.parametrize("value", ["{from: search, value: nonesuch}", "{from: staging, value: nonesuch}"])
def test_a_reference_to_nothing(value: str) -> None:
    with pytest.raises(UserError, match=r"^override staging\.searches\.swarm\.c1="):
        run_of(["study=lfp_cuckoo", f"staging.searches.swarm.c1={value}"])


def test_the_unexpected_is_one_line_at_snakemake_s_door_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("two\nlines")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("pipeline.config.planning.make_plan", fail)
    with pytest.raises(SystemExit) as left:
        open_workflow({"overrides": "seed=1"})
    assert left.value.code == 1
    told = capsys.readouterr().err
    assert told.startswith("error: RuntimeError: two lines (unexpected; details in results/logs/error-")
    assert told.count("\n") == 1
