"""The shipped statements: every name in them exists, and every verdict follows from the artefacts, both ways."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pipeline.charge.vocabulary import SUMMARY
from pipeline.config.compose import compose_tree
from pipeline.config.sources import Source
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.kernel import tables
from pipeline.published.artefacts import Lookup
from pipeline.published.evaluate import VERDICTS, evaluate
from pipeline.published.records import Statement, Told, compared, needs
from pipeline.published.vocabulary import check_statements
from pipeline.published.wording import Wording
from pipeline.report.claims import cited
from tests import making
from tests.published.conftest import CONF, FALSE, write_charge, write_points, write_reference, write_switched
from tests.published.search_world import (
    AS_PUBLISHED_HERE,
    OTHERWISE_HERE,
    SEARCH_INPUTS,
    write_search,
    write_sums,
)

STATEMENTS = list(yaml.safe_load((CONF / "solar_reflex.yaml").read_text(encoding="utf-8")))
MODES = ("cc_cv", "cv_pulse", "cv_reflex")
CHARGES = {f"charge/{comparison}/{mode}" for comparison in ("same_peak", "same_mean") for mode in MODES}
INPUTS = {"panel", "supply", "switched", "reference/solar_table1"} | CHARGES | SEARCH_INPUTS
# What cannot hold beside Table 1, and beside a Table 2 of the same ISE as Figure 10.
EXCLUDED = {"table_2_sums_iterations"}
# mode -> time to 95 %, peak rise, rise at 95 %, charge efficiency, energy efficiency
AS_PUBLISHED = {
    "cc_cv": (9500.0, 22.0, 20.0, 0.975, 0.90),
    "cv_pulse": (9800.0, 6.0, 5.0, 0.960, 0.88),
    "cv_reflex": (9700.0, 4.0, 3.0, 0.990, 0.89),
}
OTHERWISE = {
    "cc_cv": (9500.0, 5.0, 4.0, 0.990, 0.95),
    "cv_pulse": (9000.0, 5.5, 6.0, 0.980, 0.92),
    "cv_reflex": (5000.0, 6.0, 5.0, 0.950, 0.91),
}


def parts(stated: Statement) -> Iterator[Told]:
    """Yield what says how the predicates of a statement call what they compare."""
    checks: list[Any] = [] if stated.check is None else [stated.check]
    while checks:
        one = checks.pop()
        own = [getattr(one, field) for field in type(one).model_fields]
        checks += [inner for part in own if isinstance(part, tuple) for inner in part]
        yield from (part for part in own if isinstance(part, Told))


def world(
    folder: Path, modes: dict[str, Any], final_soc: float, bulk_end_s: float, best_mw2_s: float = 0.0, **points: float
) -> Lookup:
    folders = {name: folder / name for name in INPUTS if not name.startswith(("reference/", "supply"))}
    for name in CHARGES:
        time, peak, rise, charge, energy = modes[name.split("/")[2]]
        summary = {
            "time_to_soc_0.95_s": time,
            "peak_temperature_rise_k": peak,
            "peak_temperature_c": 25.0 + peak,
            "temperature_rise_at_soc_0.95_k": rise,
            "charge_efficiency": charge,
            "energy_efficiency": energy,
            "system_efficiency": energy,
        }
        write_charge(folders[name], summary, bulk_end_s, final_soc)
    write_points(folders["panel"], **points)
    write_switched(folders["switched"], 0.004 if final_soc > 0.95 else 0.0001)
    write_reference(folder, **({} if final_soc > 0.95 else {"power_w": 70.0}))
    searched = AS_PUBLISHED_HERE if final_soc > 0.95 else OTHERWISE_HERE
    write_search(folders, folder, searched | ({"best_mw2_s": best_mw2_s} if best_mw2_s else {}))
    return Lookup(making.inputs(folders), folder)


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory: pytest.TempPathFactory, shipped: dict[str, Statement]) -> dict[str, dict[str, str]]:
    """Return world -> statement -> verdict."""
    folder = tmp_path_factory.mktemp("worlds")
    worlds = {
        "as published": world(folder / "a", AS_PUBLISHED, 0.99, 3600.0),
        "otherwise": world(folder / "b", OTHERWISE, 0.80, 1800.0, short_circuit_current_a=4.1),
        "another reading": world(folder / "c", AS_PUBLISHED, 0.99, 3600.0, best_mw2_s=12.9, max_power_w=300.0),
        "empty": Lookup(making.inputs({}), folder),
    }
    found = {}
    for name, artefacts in worlds.items():
        columns = evaluate(shipped, artefacts)
        tables.to_arrow(VERDICTS, columns)
        found[name] = dict(zip(columns["statement"], columns["verdict"], strict=True))
    return found


@pytest.mark.parametrize("statement", STATEMENTS)
def test_no_verdict_is_constant(statement: str, verdicts: dict[str, dict[str, str]], shipped: Any) -> None:
    if shipped[statement].basis == "none":
        assert {found[statement] for found in verdicts.values()} == {"not checkable"}
        return
    holding = "another reading" if statement in EXCLUDED else "as published"
    assert verdicts[holding][statement] == "holds"
    assert verdicts["otherwise"][statement] == FALSE[shipped[statement].basis]
    assert verdicts["empty"][statement] == "not checkable"


@pytest.fixture(scope="module")
def study() -> Any:
    return study_from(compose_tree(["study=solar_reflex"]))


def test_every_name_exists(shipped: dict[str, Statement], study: Any) -> None:
    """Composing the study checks the names."""
    assert study.published == shipped
    assert set().union(*(needs(stated) for stated in shipped.values())) == INPUTS - {"supply"}


def test_the_printed_table_3_holds_the_sums_of_the_printed_table_2(
    shipped: dict[str, Statement], tmp_path: Path
) -> None:
    """Table 3 is made of the sums of the printed Table 2; both shipped files are read, not copies in the test."""
    runs = np.genfromtxt(CONF / "reference" / "solar_table2.csv", delimiter=",", names=True)
    sums = [
        [runs["ise"][runs[name] == np.unique(runs[name])[row]].sum() for name in ("c1", "c2", "w")] for row in range(4)
    ]
    write_sums(tmp_path / "tuning", sums)
    reader = Lookup(making.inputs({"tuning": tmp_path / "tuning"}))
    columns = evaluate({"table_3": shipped["table_3"]}, reader)
    assert columns["verdict"] == ["holds"]
    assert columns["margin"][0] == pytest.approx(5e-5, abs=1e-9)


def test_the_printed_table_is_the_papers(shipped: dict[str, Statement]) -> None:
    """Table 1 holds for its own numbers; the shipped file is read, not a copy in the test."""
    reader = Lookup(making.inputs({}))
    columns = evaluate({"table_1_power": shipped["table_1_power"]}, reader)
    assert (columns["verdict"], columns["computed_value"]) == (["holds"], [65.25])


@pytest.mark.parametrize(
    ("operand", "message"),
    [
        ("soc of charge/same_peek/cc_cv.trace", "unknown 'same_peek' in charge/same_peek/cc_cv.*same_peak"),
        ("soc of charge/same_peak/cc_vc.trace", "unknown 'cc_vc' in charge/same_peak/cc_vc.*cc_cv"),
        ("soc of charges/same_peak/cc_cv.trace", "unknown input 'charges/same_peak/cc_cv'"),
        ("soc of charge/same_peak/cc_cv.traces", "no table 'traces'.*trace"),
        ("voc of panel", "nothing called 'voc'"),
        ("time_to_soc_0.93_s of charge/same_peak/cc_cv", "nothing called 'time_to_soc_0.93_s'.*time_to_soc_0.9"),
        ("ise_at_clasic of objective.quantities", "nothing called 'ise_at_clasic'.*ise_at_classic"),
        ("end_s of charge/same_peak/cc_cv.phases where fase=bulk", "nothing called 'fase'.*phase"),
        ("p_max_w of reference/solar_table4", "unknown 'solar_table4' in reference/solar_table4.*solar_table1"),
        ("p_max_w of reference/solar_table1.rows", "no table 'rows'"),
    ],
)
def test_a_name_that_does_not_exist_is_refused_with_the_best_matches(operand: str, message: str, study: Any) -> None:
    stated = Statement.model_validate(
        {"where": "x", "says": "y", "basis": "model", "check": {"less": {"value": operand, "than": 1}}}
    )
    with pytest.raises(UserError, match=rf"published\.wrong: .*{message}"):
        check_statements(study.model_copy(update={"published": {"wrong": stated}}))


def test_a_calibration_to_an_unknown_statement_is_refused(study: Any) -> None:
    fitted = {"panel.max_power_w": Source(kind="calibrated", ref="x", to="solar_reflex.table_9")}
    with pytest.raises(UserError, match=r"'table_9'.*table_1"):
        check_statements(study.model_copy(update={"sources": fitted}))


def test_marks_become_quantities() -> None:
    assert {"time_to_soc_0.8_s", "temperature_rise_at_soc_0.95_k"} <= SUMMARY.names({"mark": (0.8, 0.95)})


def test_a_name_that_no_sentence_says_is_refused() -> None:
    with pytest.raises(UserError, match=r"called\.peak_temperature_k: no statement reads 'peak_temperature_k'; best"):
        study_from(compose_tree(["study=nicd_grnn", "+called.peak_temperature_k=warmest"]))


@pytest.mark.parametrize("name", ["solar_reflex", "nicd_grnn", "lfp_cuckoo"])
def test_every_figure_of_a_paper_is_drawn_or_said_why_not(name: str) -> None:
    """By their numbers: no gap up to the last, and none that a statement cites or a caption names is missing."""
    study = study_from(compose_tree([f"study={name}"]))
    there = {card.paper for card in study.figures.values() if card.paper} | set(study.not_drawn)
    numbers = sorted(int(one.split()[1]) for one in there if one.startswith("Figure"))
    assert sorted(set(numbers)) == list(range(1, numbers[-1] + 1))
    asked = {one for stated in study.published.values() for one in cited(stated.where, "Figure")}
    assert asked | {one for one in study.captions if one.startswith("Figure")} <= there
    assert not {card.paper for card in study.figures.values()} & set(study.not_drawn)


@pytest.mark.parametrize("name", ["solar_reflex", "nicd_grnn", "lfp_cuckoo"])
def test_sentences_say_words_and_no_keys(name: str) -> None:
    study = study_from(compose_tree([f"study={name}"]))
    titles = {mode: study.modes[mode].title for mode in study.run}
    told = Wording(Lookup(making.inputs({})), "1", titles | study.called)
    for stated in study.published.values():
        for part in parts(stated):
            names = part.called or [told.label(one) for one in compared(part)]
            assert not [one for one in (part.of, *names) if "_" in one or "degC" in one]
