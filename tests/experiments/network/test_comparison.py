"""Selections held against each other: from which generation, of which sizes, of how many units."""

from __future__ import annotations

import numpy as np

from pipeline.experiments.network.comparison import after, compare, sizes, units
from pipeline.search.genetic import GeneticSettings

GENETIC = GeneticSettings()


def test_a_comparison_takes_the_used_network_from_its_generation(study, surfaces):
    changes = {"methods": ("genetic", "regular"), "replicates": 3, "generations": 10, "long_generations": 25}
    settings = study.selection.model_copy(update=changes)
    widths = study.form.widths.model_copy(update={"temperature": (0.1,), "gradient": (10.0,)})
    form = study.form.model_copy(update={"widths": widths})
    found = compare(form, settings, surfaces["plateau_ramp"], 4)
    used = found.results["genetic"].selected
    np.testing.assert_array_equal(used.error, found.course.history.value[:, 10])
    assert used.evaluations == 20 + 10 * 18
    short = compare(form, settings.model_copy(update={"long_generations": 10}), surfaces["plateau_ramp"], 4)
    np.testing.assert_array_equal(short.results["genetic"].selected.rows, used.rows)
    assert np.all(after(found.course, 25).error <= used.error)


def test_more_centres_are_selected_for_the_sizes_asked_for(study, surfaces):
    asked = study.size.model_copy(update={"smallest": 2, "largest": 3, "generations": 20, "replicates": 2})
    widths = study.form.widths.model_copy(update={"temperature": (0.1,), "gradient": (10.0,)})
    form = study.form.model_copy(update={"widths": widths})
    found = list(sizes(form, GENETIC, asked, surfaces["plateau_ramp"], 1))
    assert [one.centres for one in found] == [2, 3]
    assert found[1].forward_error < found[0].forward_error
    assert all(len(one.error) == 2 for one in found)


def test_units_are_counted_as_the_paper_counts_them():
    assert (units(6), units(561)) == (13, 1123)
