"""What Snakemake hands on is read as it was typed."""

from __future__ import annotations

import shlex

import pytest
from hypothesis import given
from hypothesis import strategies as st
from snakemake.cli import parse_config

from pipeline.commands.workflow import as_typed, split_overrides

WORDS = st.lists(st.text(st.characters(codec="ascii", exclude_categories=["Cc"]), min_size=1), min_size=2, max_size=4)


@given(WORDS)
def test_words_come_through_snakemake_as_they_were_typed(words: list[str]) -> None:
    typed = f"overrides=study=x {shlex.join(words)}"
    handed_on = str(parse_config([typed])["overrides"])
    assert split_overrides(as_typed(handed_on, ["snakemake", "all", "--config", typed])) == ["study=x", *words]


@pytest.mark.parametrize("typed", [[], ["snakemake", "--config", "plan=x"], ["overrides"]])
def test_what_was_not_typed_stays_as_it_is(typed: list[str]) -> None:
    assert as_typed("study=x 'a b' c", typed) == "study=x 'a b' c"
