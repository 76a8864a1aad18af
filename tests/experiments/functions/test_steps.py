"""The function study from its configuration to tables, figures, targets; a small one beside the study of the panel."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pipeline.config import planning
from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.experiments.functions import function_runs, functions, page
from pipeline.experiments.functions.figures._parts import PLACES
from pipeline.experiments.functions.numbers import VOCABULARY, fields
from pipeline.kernel import digest, publish, store
from pipeline.kernel.draft import drafts
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import ReportData
from tests import making

SMALL = (
    "+functions=quick",
    "functions.functions=[sphere,rastrigin]",
    "functions.variants.shared.generations=40",
    "functions.variants.replicates=5",
    "functions.baselines.searches.differential_evolution.generations=5",
    "functions.baselines.searches.swarm.iterations=5",
    "functions.baselines.replicates=2",
)
SEARCHES = {"cuckoo": "plain", "inertia": "with inertia"}


@cache
def composed(*words):
    return study_from(compose_tree((*SMALL, *words)))


def nodes(*words):
    return {node.name: node for node in drafts(composed(*words))}


def card(draw, **options):
    return FigureCard(draw=draw, title="t", caption="c", options={"searches": SEARCHES, **options})


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    root, made = tmp_path_factory.mktemp("functions"), {}
    for name, node in nodes().items():
        if node.step in ("function_runs", "functions"):
            made[name] = root / name
            step = function_runs if node.step == "function_runs" else functions
            inputs = making.inputs({one: made[one] for one in node.inputs})
            step.run(node.settings, inputs, making.output(node.step, made[name]))
    return made


@pytest.fixture(scope="module")
def data(outputs):
    return ReportData(making.inputs(outputs), {}, {})


def test_a_node_for_each_function_and_one_that_compares():
    found = nodes()
    assert found["functions"].inputs == {name: name for name in ("function_runs/sphere", "function_runs/rastrigin")}
    assert "functions" in found["page"].inputs
    assert found["function_runs/sphere"].modules == tuple(
        f"pipeline.search.algorithms.{kind}" for kind in ("cuckoo", "differential_evolution", "swarm")
    )
    assert "functions" not in {node.name for node in drafts(study_from(compose_tree(())))}


def test_what_a_function_gives_does_not_depend_on_the_others():
    alone = nodes("functions.functions=[sphere]")["function_runs/sphere"]
    assert alone.settings == nodes()["function_runs/sphere"].settings
    other = nodes("functions.threshold=1e-3")["function_runs/sphere"]
    assert other.settings != alone.settings


def test_the_view_shows_every_table_and_each_is_declared(outputs, data):
    files = {path.name for path in outputs["functions"].glob("*.parquet")}
    assert set(nodes()["functions"].shown) == files
    for name in ("statistics", "tests", "ranks", "quantities"):
        assert len(next(iter(data.table("functions", name).values()))) > 0


def test_the_named_numbers_are_those_that_statements_may_name(data):
    found = data.table("functions", "quantities")["quantity"].tolist()
    assert sorted(found) == sorted(VOCABULARY.names(fields(composed().functions)))


def test_the_tables_of_the_page_hold_every_search(data):
    shown = {table.name: table for table in page.tables(data)}
    assert [table.paper for table in shown.values() if table.paper] == ["Table 1", "Table 2"]
    assert len(shown["table_1_functions"].rows) == len(shown["table_2_functions"].rows) == 2 * 3 * 7
    assert len(shown["functions_tests"].rows) == 2 * 3 * 4 * 2
    placements = [row[0] for row in shown["functions_summary"].rows]
    assert placements == sorted(placements, key=list(PLACES.values()).index)
    assert page.tables(ReportData(making.inputs({}), {}, {})) == []


def test_curves_are_drawn_as_they_are(data):
    with style.active():
        chosen = card("function_convergence", functions=["rastrigin", "sphere"], placements=["centred", "shifted"])
        found = chosen.drawing().draw(chosen, data)
    axes = found.get_axes()[1]
    table = data.table("functions", "curves")
    rows = (table["function"] == "sphere") & (table["placement"] == "centred") & (table["search"] == "inertia")
    line = next(one for one in axes.get_lines() if one.get_color() == style.MARKS[1].colour)
    np.testing.assert_array_equal(line.get_ydata(), np.maximum(table["median"][rows], 1e-20))
    assert len(found.get_axes()) == 4


def test_placements_are_drawn_where_the_means_are(data):
    with style.active():
        chosen = card("function_placements")
        found = chosen.drawing().draw(chosen, data)
    table = data.table("functions", "statistics")
    rows = (table["search"] == "inertia") & (table["placement"] == "shifted")
    dots = [one for one in found.get_axes()[1].get_lines() if one.get_marker() == style.MARKS[1].marker]
    assert [one.get_xdata()[0] for one in dots] == table["mean"][rows].tolist()
    share = data.numbers("functions")["inertia_centred_mean_success_share"]
    assert f"{100 * share:.0f} /" in found.get_axes()[1].get_title(loc="left")


def needed(made, target):
    waiting, seen = list(made["targets"][target]), set()
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            waiting += made["chunks"][name]["needs"]
    return seen


def test_a_run_on_request_is_made_for_its_target_alone(monkeypatch):
    request = {"all_of_it": ["functions.variants.replicates=30"]}

    def with_request(words):
        found = compose_tree((*SMALL, *words))
        return replace(
            found, overrides=tuple(words), tree=found.tree | {"study": found.tree["study"] | {"on_request": request}}
        )

    monkeypatch.setattr(planning, "compose_tree", with_request)
    made = planning.make_plan([[]])
    assert [run["overrides"] for run in made["runs"]] == [[], request["all_of_it"]]
    usual, whole = needed(made, "all"), needed(made, "all_of_it")
    assert usual == needed(made, "report") == needed(made, "solar_reflex")
    runs = {name for name, chunk in made["chunks"].items() if chunk["step"] == "function_runs"}
    assert len(runs & usual) == len(runs & whole) == 1
    assert not runs & usual & whole
    charges = {name for name, chunk in made["chunks"].items() if chunk["step"] == "charge"}
    assert charges <= usual & whole, "what both have is made once"
    made_twice = [key for chunk in made["chunks"].values() if "nodes" in chunk for key in chunk["nodes"]]
    assert sorted(made_twice) == sorted(made["nodes"])
    assert len(planning.make_plan([["functions.threshold=1e-3"]])["runs"]) == 1


def test_the_page_shows_what_was_computed_on_request_while_its_key_is_the_same(monkeypatch, tmp_path):
    request = ["functions.variants.replicates=30"]

    def with_request(words):
        found = compose_tree((*SMALL, *words))
        study = found.tree["study"] | {"on_request": {"all_of_it": request}}
        return replace(found, overrides=tuple(words), tree=found.tree | {"study": study})

    def keys(run):
        return {key for key, node in made["nodes"].items() if node["step"] == "function_runs"} & {
            node["key"] for node in run["nodes"].values()
        }

    monkeypatch.setattr(planning, "compose_tree", with_request)
    monkeypatch.setattr(store, "RESULTS", tmp_path)
    made = planning.make_plan([[]])
    usual, whole = map(keys, made["runs"])
    assert not usual & whole
    manifest = tmp_path / "solar_reflex" / planning.run_name(request) / publish.MANIFEST
    computed = [store.artefact(tmp_path, made["nodes"][key]["step"], key) / store.CONTENTS for key in whole]
    for file in (manifest, *computed):
        file.parent.mkdir(parents=True)
        file.write_text("{}")
    with digest.recorded() as seen:
        made = planning.make_plan([[]], [])
    (run,) = made["runs"]
    assert (run["name"], run["overrides"], keys(run)) == ("default", [], whole)
    assert {str(file) for file in (manifest, *computed)} <= set(seen)
    computed[0].unlink()
    with digest.recorded() as seen:
        made = planning.make_plan([[]], [])
    assert keys(made["runs"][0]) == usual
    assert seen[str(computed[0])] == digest.ABSENT


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("functions.functions=[sphere,spere]",), r"functions\.functions.*no test function 'spere'"),
        (("functions.variants.searches.inertia.inertia=1.5",), "inertia"),
        (("+functions.variants.searches.other.nest=3",), "nest"),
        (("+study.on_request={figures:[seed]}",), "target 'figures' is taken"),
        (("+study.on_request={larger:[]}",), "no overrides"),
    ],
)
def test_a_mistake_is_named(words, message):
    with pytest.raises(UserError, match=message):
        composed(*words)


def test_the_full_study_has_the_papers_size():
    study = study_from(compose_tree(("+functions=full",)))
    searches = study.functions.searches(1.0)
    assert {name for name in searches if searches[name].replicates == 30} == set(study.functions.variants.searches)
    assert all(searches[name].generations == 5000 for name in study.functions.variants.searches)
    assert {"genetic", "particle_swarm"} <= set(searches)
