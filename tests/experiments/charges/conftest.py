"""Runs of charges that never were: of many kinds, whole, and limited by the supply."""

from __future__ import annotations

import pytest

from pipeline.report.tables import ReportData
from tests.experiments.charges.artefacts import VARIANTS, build
from tests.experiments.drawing import cards

HERE = {"charge", "second_charge", "panel", "supply", "chaos", "objective", "tuning", "search"}
LABELS = {"cells", "modes", "battery", "system", "algorithm", "switched"}


@pytest.fixture(scope="session", params=list(VARIANTS))
def data(request, tmp_path_factory) -> ReportData:
    return build(tmp_path_factory.mktemp("artefacts"), **VARIANTS[request.param])


@pytest.fixture(scope="session")
def whole(tmp_path_factory) -> ReportData:
    return build(tmp_path_factory.mktemp("whole"))


@pytest.fixture(scope="session")
def limited(tmp_path_factory) -> ReportData:
    return build(tmp_path_factory.mktemp("limited"), supply_limited_s=3000.0)


def pytest_generate_tests(metafunc) -> None:
    if "name" in metafunc.fixturenames and "card" in metafunc.fixturenames:
        found = {name: card for name, card in cards().items() if set(card.reads()) <= HERE | LABELS}
        if "data" in metafunc.fixturenames:  # the runs differ in charges and supply alone
            found = {name: card for name, card in found.items() if {"charge", "supply"} & set(card.reads())}
        metafunc.parametrize(("name", "card"), list(found.items()), ids=list(found))
