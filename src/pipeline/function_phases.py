"""The nodes of a study of searches on test functions."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.config.study import Study
from pipeline.draft import Draft, plain
from pipeline.search import registry

_FILES = ("runs", "curves", "statistics", "tests", "ranks", "quantities")


def functions(study: Study) -> Iterator[Draft]:
    """Yield a node for each function, with the runs of every search on it, and one that compares the searches."""
    if study.functions is None:
        return
    chosen = study.functions
    modules = tuple(sorted(registry.module_name(kind) for kind in chosen.kinds()))
    names = [f"function_runs/{name}" for name in chosen.functions]
    for node, name in zip(names, chosen.functions, strict=True):
        # What a function gives does not depend on which others there are.
        own = plain(chosen.model_copy(update={"functions": (name,)}))
        settings = {"functions": own, "function": name, "seed": study.seed}
        yield Draft("function_runs", node, name, settings, sections=("functions",), modules=modules)
    yield Draft(
        "functions",
        "functions",
        "functions",
        {"functions": plain(chosen), "seed": study.seed},
        inputs={name: name for name in names},
        sections=("functions",),
        shown={f"{file}.parquet": f"functions/{file}.parquet" for file in _FILES},
    )
