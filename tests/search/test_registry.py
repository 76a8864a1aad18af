from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from pipeline.record import Record
from pipeline.search import registry
from pipeline.search.algorithms import swarm, sweep
from pipeline.search.box import History, SearchSettings

VALUES = {"kind": "sweep", "title": "sweep", "points": 11, "variables": {"x": {"low": 0.0, "high": 1.0}}}


def test_every_module_of_the_folder_is_an_algorithm_of_its_own_name():
    assert list(registry.names()) == [
        "cuckoo", "differential_evolution", "genetic", "particle_swarm", "swarm", "sweep",
    ]  # fmt: skip
    for name in registry.names():
        module = registry.algorithm(name)
        assert issubclass(module.Settings, SearchSettings)
        assert module.Settings.model_fields["kind"].default == name
        assert callable(module.minimise)


def test_kind_chooses_the_settings():
    assert isinstance(registry.settings_from(VALUES), sweep.Settings)

    class Card(Record):
        search: registry.AnySettings

    card = Card(search=VALUES)
    assert isinstance(card.search, sweep.Settings)
    assert card.model_dump()["search"]["points"] == 11
    with pytest.raises(ValidationError, match="no search algorithm 'swam'; best matches are: swarm"):
        Card(search={**VALUES, "kind": "swam"})
    with pytest.raises(ValidationError, match="kind is None; it names a search algorithm"):
        Card(search={"title": "x"})


def test_box_keeps_the_order_of_the_variables(swarm_settings):
    settings = swarm_settings(variables={"b": {"low": 0.0, "high": 1.0}, "a": {"low": -2.0, "high": 3.0}})
    assert settings.box().low.tolist() == [0.0, -2.0]
    assert settings.box().high.tolist() == [1.0, 3.0]
    with pytest.raises(ValidationError, match="low is 2; it must lie below high, 1"):
        swarm_settings(variables={"b": {"low": 2.0, "high": 1.0}})


def test_an_algorithm_without_replicate_is_replicated(monkeypatch):
    class Single:
        Settings = sweep.Settings

        @staticmethod
        def minimise(objective, box, settings, rng):
            x = rng.uniform(box.low, box.high, (1, 1))
            return History(np.array([[1]]), x[None], objective(x)[None])

    monkeypatch.setattr(registry, "algorithm", lambda kind: Single)
    settings = sweep.Settings(**VALUES, replicates=3)
    history = registry.replicated(lambda x: x[:, 0], settings, 9)
    expected = [np.random.default_rng(np.random.SeedSequence([9, i])).uniform() for i in range(3)]
    assert history.best_value().tolist() == pytest.approx(expected)


def test_history_as_a_table(swarm_settings):
    settings = swarm_settings(replicates=2, iterations=3)
    history = swarm.replicate(lambda x: np.sum(x**2, axis=1), settings.box(), settings, 1)
    table = history.columns(settings.variables)
    assert list(table) == ["replicate", "iteration", "evaluations", "x", "y", "value"]
    assert table["replicate"].tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    assert table["iteration"].tolist() == [0, 1, 2, 3] * 2
    np.testing.assert_allclose(table["x"] ** 2 + table["y"] ** 2, table["value"])


def test_a_grid_too_fine_is_refused():
    with pytest.raises(ValidationError, match="points is 1001 along each of 3 variables"):
        sweep.Settings(title="x", points=1001, variables={name: {"low": 0.0, "high": 1.0} for name in ("x", "y", "z")})
