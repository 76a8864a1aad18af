"""Files of the configuration: YAML 1.2 and no more, bounded, and named in every refusal."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from pipeline.config import adapter, yaml_file
from pipeline.config.compose import compose_tree, expand
from pipeline.config.inheritance import CONF
from pipeline.config.study import study_from
from pipeline.errors import UserError


@pytest.fixture
def conf(tmp_path: Path) -> Path:
    return Path(shutil.copytree(CONF, tmp_path / "conf"))


def read(tmp_path: Path, text: str) -> dict[str, Any]:
    file = tmp_path / "one.yaml"
    file.write_text(text)
    return yaml_file.document(file).tree


# https://yaml.org/spec/1.2.2/#103-core-schema
@pytest.mark.parametrize(
    ("written", "value"),
    [
        *[
            (word, word)
            for word in ("1:30", "190:20:30", "yes", "no", "on", "off", "y", "N", "1_000", "0b101", "1_0.5")
        ],
        *[(word, word) for word in ("2015-03-20", "１２", "1e", ".", "+", "0o9", "tRUE", "nULL", "=", "1,5", "٣")],
        *[(word, True) for word in ("true", "True", "TRUE")],
        *[(word, None) for word in ("null", "~", "Null", "")],
        *[("014", 14), ("0o14", 12), ("0x1F", 31), ("-7", -7), ("+7", 7), ("1e3", 1000.0), ("-.5", -0.5), ("7.", 7.0)],
        *[(".inf", float("inf")), ("-.Inf", float("-inf")), ("!!str 12", "12"), ("'12'", "12"), ('"yes"', "yes")],
    ],
)
def test_scalars_are_those_of_yaml_1_2(tmp_path: Path, written: str, value: Any) -> None:
    found = read(tmp_path, f"a: {written}\n")["a"]
    assert found == value
    assert type(found) is type(value)


def test_a_key_is_a_name_as_it_is_written(tmp_path: Path) -> None:
    assert read(tmp_path, "on: 1\n1: 2\nnull: 3\ntrue: 4\n") == {"on": 1, "1": 2, "null": 3, "true": 4}


def test_aliases_and_lines(tmp_path: Path) -> None:
    file = tmp_path / "one.yaml"
    file.write_text("a: &x\n  b: [1, 2]\nc: *x\nd:\n  - e: 1\n  - f: 2\n")
    found = yaml_file.document(file)
    assert found.tree == {"a": {"b": [1, 2]}, "c": {"b": [1, 2]}, "d": [{"e": 1}, {"f": 2}]}
    assert [found.lines[place] for place in (("a", "b"), ("c",), ("d", 1, "f"))] == [2, 3, 6]


BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 12)
)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (BOMB, r":\d: more than 100000 values, with aliases written out"),
        ("a: " + "[" * 3000 + "]" * 3000, ":1: nested deeper than 64 levels"),
        ("a: " + "{b: " * 3000 + "1" + "}" * 3000, ":1: nested deeper than 64 levels"),
        ("a: &x [*x]\n", r":1: (not readable YAML|\*x stands for nothing)"),
        ("a: !!python/object:os.system x\n", r":1: !!python/object:os.system is a tag"),
        ("a: 1\nb: !!python/object/apply:os.system [ls]\n", ":2: !!python/object/apply:os.system is a tag"),
        ("a: !!float 1\n", ":1: !!float is a tag"),
        ("a: {<<: {b: 1}}\n", ":1: << merges"),
        ("a: 1\n---\nb: 2\n", ":2: a second document"),
        ("? [a]\n: 1\n", ":1: a list or a mapping is no key"),
        ("a: *b\n", r":1: "),
        ("a: 'b\n", r":\d: not readable YAML"),
        ("a: \x07\n", ": not readable YAML"),
        ("a: 1\n" + "#" * (1 << 20), r": \d+ bytes; .* up to 1024 KiB"),
    ],
)
def test_what_is_no_yaml_of_ours_is_refused_with_file_and_line(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(UserError) as refused:
        read(tmp_path, text)
    assert re.match(re.escape(str(tmp_path / "one.yaml")) + told, str(refused.value))


def test_utf_16_is_read_where_it_is_marked_and_else_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "one.yaml"
    for encoding in ("utf-16", "utf-8-sig"):
        file.write_text("a: ä\n", encoding=encoding)
        assert yaml_file.document(file).tree == {"a": "ä"}
    file.write_bytes(b"a: 1\nb: \xff\xfe\n")
    with pytest.raises(UserError, match=r"one\.yaml:2: not UTF-8 text"):
        yaml_file.document(file)


def _folder(file: Path) -> None:
    file.mkdir()


def _pipe(file: Path) -> None:
    os.mkfifo(file)


def _zeros(file: Path) -> None:
    file.symlink_to("/dev/zero")


def _broken(file: Path) -> None:
    file.symlink_to("nothing")


def _circle(file: Path) -> None:
    file.symlink_to(file)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (_folder, "is a folder; allowed is a YAML file"),
        (_pipe, "is a pipe"),
        (_zeros, "is a device"),
        (_broken, "is a link to a file that is not there"),
        (_circle, "cannot be read"),
    ],
)
@pytest.mark.parametrize("group", ["battery", "modes"])
def test_what_is_no_file_is_said_as_such(conf: Path, make: Any, told: str, group: str) -> None:
    make(conf / group / "odd.yaml")
    words = ["battery=odd"] if group == "battery" else []
    with pytest.raises(UserError, match=rf"conf/{group}/odd\.yaml: {told}"):
        compose_tree(words, conf)


def test_an_editor_s_lock_file_is_no_option(conf: Path) -> None:
    (conf / "modes" / ".#cc_cv.yaml").symlink_to("user@host.1234")
    compose_tree([], conf)


@pytest.mark.parametrize("name", ["two words", "a=b", "ä", "1st", "a,b"])
def test_a_mode_s_file_has_a_name_that_can_be_a_key(conf: Path, name: str) -> None:
    (conf / "modes" / f"{name}.yaml").write_text("title: x\n")
    with pytest.raises(UserError, match=rf"conf/modes/{name}\.yaml: its name is also that of its key"):
        compose_tree([], conf)


@pytest.mark.parametrize(
    ("defaults", "told"),
    [
        ("[odd, _self_]", r"battery/odd\.yaml:1: defaults come back to where they began: .*odd\.yaml -> .*odd\.yaml"),
        ("[other]", r"battery/other\.yaml:1: defaults come back to where they began: .*odd.*-> .*other.*-> .*odd"),
        (
            "[/study: solar_reflex]",
            r"defaults come back to where they began: .*solar_reflex.*-> .*odd",
        ),
        ("[../study/solar_reflex]", r"battery/odd\.yaml:1: defaults: entry"),
        ("[../../outside]", r"battery/odd\.yaml:1: defaults: entry"),
        ("5", r"battery/odd\.yaml:1: defaults: value '5'; allowed is a list"),
        ("[5]", r"battery/odd\.yaml:1: defaults: entry '5'; allowed"),
        ("[{a: b, c: d}]", r"battery/odd\.yaml:1: defaults: entry"),
        ("[[lead_acid_12v7ah]]", r"battery/odd\.yaml:1: defaults: entry"),
        ("[{battery: {a: 1}}]", r"battery/odd\.yaml:1: defaults: entry"),
        ("[{/battery: '${oc.env:HOME}'}]", r"battery/odd\.yaml:1: defaults: entry"),
        ("[nonesuch]", "nonesuch"),
    ],
)
def test_a_defaults_list_leads_to_files_of_conf_and_not_back(conf: Path, defaults: str, told: str) -> None:
    (conf / "battery" / "odd.yaml").write_text(f"defaults: {defaults}\nname: odd\n")
    (conf / "battery" / "other.yaml").write_text("defaults: [odd]\n")
    with pytest.raises(UserError, match=told):
        compose_tree(["battery=odd"], conf)


ENVIRONMENT = "${oc.env:CHARGE_SECRET}"


@pytest.mark.parametrize(
    "value",
    [
        ENVIRONMENT,
        "${oc.env:CHARGE_SECRET,none}",
        "${oc.decode:'${oc.env:CHARGE_SECRET}'}",
        "${${study.doi}:CHARGE_SECRET}",
        "${oc.create:${study}}",
        "${now:%Y}",
        "${hydra:runtime.cwd}",
        "a ${ oc.env:CHARGE_SECRET } b",
    ],
)
def test_nothing_outside_the_configuration_is_read(conf: Path, value: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CHARGE_SECRET", "hunter2")
    study = conf / "study" / "solar_reflex.yaml"
    study.write_text(study.read_text().replace("question: >-", f'note: "{value}"\n  question: >-'))
    line = 1 + study.read_text().splitlines().index(f'  note: "{value}"')
    with pytest.raises(UserError, match=rf"conf/study/solar_reflex\.yaml:{line}: study\.note: value .*no environment"):
        compose_tree([], conf)
    with pytest.raises(UserError, match=r"override study\.title=.*: study\.title: value .*no environment"):
        compose_tree([f'study.title="{value}"'])


def test_dollars_that_are_escaped_stay_as_they_are() -> None:
    assert compose_tree([r"study.title='\${oc.env:HOME}'"]).tree["study"]["title"] == "${oc.env:HOME}"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["study.title=${study.question}", "study.question=${study.title}"], "follows itself: study.title ->"),
        (["engine=${engine}"], "follows itself"),
        (["+engine.x=${engine}"], "follows itself"),
        (["engine.driver=${engine.divers}"], r"override engine\.driver=.*: engine has no key 'divers'; best .* driver"),
        (["seed=???"], r"override seed=\?\?\?: seed: value '\?\?\?', which is yet to be given"),
    ],
)
def test_interpolations_that_come_to_nothing(words: list[str], told: str) -> None:
    with pytest.raises(UserError, match=told):
        compose_tree(words)


def test_interpolations_cannot_grow_without_bound() -> None:
    words = ["+study.a0=" + "x" * 100]
    words += [f"+study.a{n}='{''.join([f'${{study.a{n - 1}}}'] * 9)}'" for n in range(1, 30)]
    with pytest.raises(UserError, match="comes to more than 100000 values or 1000000 letters"):
        compose_tree(words)


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("battery=[1,2]", "'1' is no name of a file in conf/battery; known are: "),
        ("converter=[1,2]", "'1' is no name of a file in conf/converter"),
        ("study=[1,2]", "'1' is no name of a file in conf/study"),
        ("battery=[[a]]", "is no name of a file in conf/battery"),
        ("battery=true", "is no name of a file in conf/battery"),
        ("battery=1.5", "is no name of a file in conf/battery"),
        ("battery=../study/solar_reflex", "'../study/solar_reflex' is no name of a file in conf/battery"),
        ("battery=/etc/passwd", "'/etc/passwd' is no name"),
        ("battery=" + "a" * 5000, "is no name of a file in conf/battery"),
        ("hydra.searchpath=[file:///etc]", "Hydra's own settings none is used"),
        ("hydra/launcher=x", "Snakemake starts the jobs"),
        ("seed=1_000", "1_000 is no number or truth value of YAML 1.2; write 1000"),
        ("seed=1_0.5", "1_0.5 is no number"),
        ("study.apart=tRuE", "tRuE is no number or truth value"),
        ("seed=" + "[" * 3000 + "]" * 3000, "nested deeper than 64 levels"),
        ("study.title=" + "x" * 30000, "30012 letters; allowed are 20000"),
    ],
)
def test_words_are_judged_before_hydra_takes_them(word: str, told: str) -> None:
    with pytest.raises(UserError) as refused:
        compose_tree([word])
    assert str(refused.value).startswith("override ")
    assert told in str(refused.value)
    assert len(str(refused.value)) < 1500


@pytest.mark.parametrize(
    "value",
    ["/data/2017-03-25_2017-03-25.csv", "run_2024_01.csv", "7_1.xlsx", "a:1_0", "12_5 Ah", "x True y", "v1_0_True"],
)
def test_digits_within_a_word_are_no_number(value: str) -> None:
    assert list(adapter.spelled(f"study.title={value}")) == []
    assert compose_tree([f"study.title={value}"]).tree["study"]["title"] == value


@pytest.mark.parametrize("value", ["1_000", "[1, 1_000]", "{a: 1_000}", "choice(2,1_000)", "range(1,1_000)", " 1_000 "])
def test_numbers_that_yaml_does_not_have_are_refused_wherever_they_stand(value: str) -> None:
    assert "1_000" in list(adapter.spelled(f"seed={value}"))


@pytest.mark.parametrize("value", ["true", "false", "'12'", "１２", "yes", "1:30", "[1]", "{a: 1}", "null", "1.5"])
@pytest.mark.parametrize("key", ["seed", "engine.maximum_steps"])
def test_only_a_whole_number_is_one(key: str, value: str) -> None:
    with pytest.raises(UserError, match=r"^override "):
        study_from(compose_tree([f"{key}={value}"]))


@pytest.mark.parametrize("value", ["true", "'1.5'", "yes", "1:30", "[1]"])
def test_only_a_number_is_one(value: str) -> None:
    with pytest.raises(UserError, match=r"^override charge\.ambient_c="):
        study_from(compose_tree([f"charge.ambient_c={value}"]))


@pytest.mark.parametrize("value", ["1", "0", "'true'", "yes", "null"])
def test_only_a_truth_value_is_one(value: str) -> None:
    with pytest.raises(UserError, match=r"^override \+study\.apart="):
        study_from(compose_tree([f"+study.apart={value}"]))


def test_a_whole_number_may_be_written_as_a_float() -> None:
    assert study_from(compose_tree(["engine.maximum_steps=2e8"])).engine.maximum_steps == 200_000_000


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["seed=range(1,1000000000)"], "a sweep of 999999999 runs; allowed are 10000 at most"),
        (["seed=range(0,1,1e-300)"], "a sweep of uncounted runs"),
        (["seed=range(1,5,0)"], "a sweep of uncounted runs"),
        (["seed=range(5,1)"], "a sweep of 0 runs"),
        (["seed=range(0,200)", "+a=range(0,200)"], "a sweep of 40000 runs"),
        (["seed=interval(0,1)"], "an interval has no values to take in turn"),
    ],
)
def test_a_sweep_is_counted_before_it_is_expanded(words: list[str], told: str) -> None:
    with pytest.raises(UserError, match=r"^override seed=.*" + re.escape(told)):
        expand(words)
