"""What is shown of a configuration without a run, and what a shell completes."""

from __future__ import annotations

import subprocess
import sys

import pytest
import yaml

from pipeline.commands import looking, run
from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.errors import UserError

WORDS = ["modes.cv_reflex.frequency_hz=50"]


def test_the_configuration_is_shown_whole_in_part_or_not_at_all() -> None:
    composed = study_from(compose_tree(WORDS)).configuration
    assert yaml.safe_load(looking.shown(WORDS, "job", None)) == composed
    assert yaml.safe_load(looking.shown(WORDS, "job", "battery.thermal")) == composed["battery"]["thermal"]
    assert yaml.safe_load(looking.shown(WORDS, "hydra", None)) is None
    assert looking.shown(WORDS, "all", None) == looking.HYDRA + looking.shown(WORDS, "job", None)
    with pytest.raises(UserError, match=r"no 'thermall' there; .*thermal"):
        looking.shown(WORDS, "job", "battery.thermall")


@pytest.mark.parametrize("words", [["--cfg"], ["--cfg", "job"], ["--cfg=job"]])
def test_a_kind_of_configuration_may_be_left_out(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run.main([*words, *WORDS, "-p", "battery.thermal"]) == 0
    assert capsys.readouterr().out == looking.shown(WORDS, "job", "battery.thermal")


def test_what_composes_a_run_is_told_in_its_order() -> None:
    told = list(looking.told(WORDS))
    files = [line.split()[0] for line in told if line.startswith("  conf/")]
    assert files.index("conf/battery/lead_acid_12v7ah.yaml") < files.index("conf/study/solar_reflex.yaml")
    assert "  conf/battery/lead_acid_12v7ah.yaml at battery" in told
    assert told[-1] == "overrides: modes.cv_reflex.frequency_hz=50"


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("charge-pipeline rep", ["report", "report=", "reproduce"]),
        ("charge-pipeline battery=lead_acid_12v1", ["battery=lead_acid_12v18ah"]),
        ("charge-pipeline -m battery=lead_acid_12v7ah,lfp_8ah_m", ["battery=lead_acid_12v7ah,lfp_8ah_measured"]),
        ("charge-pipeline modes.cv_reflex.fr", ["modes.cv_reflex.frequency_hz="]),
        ("charge-pipeline battery.thermal.h", ["battery.thermal.heat_capacity_j_k="]),
        ("charge-pipeline study=nicd_grnn network.fo", ["network.form."]),
        ("charge-pipeline battery=zz", []),
    ],
)
def test_a_begun_word_is_completed(line: str, found: list[str]) -> None:
    assert sorted(looking.completed(line)) == found


def test_bash_completes_behind_the_equals_sign() -> None:
    script = f"""
charge-pipeline() {{ "{sys.executable}" -m pipeline "$@"; }}
eval "$(charge-pipeline completion bash)"
COMP_LINE="charge-pipeline battery=lead_acid_12v1"; COMP_POINT=${{#COMP_LINE}}
_charge_pipeline; printf '%s\\n' "${{COMPREPLY[@]}}"
COMP_LINE="charge-pipeline modes.cv_reflex.fr"; COMP_POINT=${{#COMP_LINE}}
_charge_pipeline; printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["lead_acid_12v18ah", "modes.cv_reflex.frequency_hz="]


def test_another_shell_is_refused() -> None:
    with pytest.raises(UserError, match="bash, zsh or fish"):
        looking.main(["tcsh"])


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["hydra.run.dir=x"], "a run lies in results/<study>/<run>"),
        (["-m", "hydra.sweep.dir=x"], "a sweep in results/<study>/sweeps/<name> (sweep.name=NAME)"),
        (["-m", "hydra/launcher=joblib"], "Snakemake starts the jobs (--cores N, or a profile)"),
        (["+hydra.sweeper.params=1"], "of Hydra's own settings none is used"),
        (["-m", "modes.cc_cv.max_current_a=interval(1,2)"], "Optuna, Ax and Nevergrad draw from one"),
        (["modes.cc_cv.max_current_a=interval(1,2)"], "give range(1,5,0.5)"),
        (["--resolve"], "option --resolve: of what --cfg prints; give --cfg beside it"),
        (["-p", "battery"], "option --package: of what --cfg prints"),
        (["--config-name=x"], "study=NAME chooses the study"),
        (["-cd", "x"], "conf/ of a project (charge-pipeline init) comes before the shipped one"),
        (["-sc"], "charge-pipeline completion bash, zsh or fish"),
        (["--hydra-help"], "--info the versions and files"),
        (["--experimental-rerun", "x"], "the same command goes on"),
        (["--conf"], "unknown; see python -m pipeline --help"),
    ],
)
def test_what_hydra_has_and_this_has_not_is_answered_in_one_line(words: list[str], told: str) -> None:
    with pytest.raises(UserError) as refused:
        run.main(["-n", *words])
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_values_are_resolved_whether_or_not_it_is_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert run.main(["--cfg", "job", "--resolve", "-p", "modes.cv_pulse.frequency_hz", *WORDS]) == 0
    assert capsys.readouterr().out == "# @package modes.cv_pulse.frequency_hz\n50\n...\n"
