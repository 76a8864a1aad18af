"""Stage currents that another step finds: one reference for the whole list."""

import pytest

from pipeline.charge.checks import check
from pipeline.charge.protocol import Resolver, parameters, resolve
from pipeline.charge.records import Mode
from pipeline.errors import UserError
from pipeline.record import Reference
from tests.charge.samples import battery, settings

FOUND = {"from": "staging", "value": "currents_a"}
EDGES = [0.5, 0.7, 0.9]


def sheet(currents, edges=EDGES):
    return Mode(
        title="staged",
        phases={"stages": {"staged": {"currents_a": currents, "soc_edges": edges}, "limit": {"voltage_v": 3.65}}},
        stop={"elapsed_s": 7200, "soc": 0.9},
    )


def test_a_reference_stands_for_the_whole_list_and_is_written_as_it_was_read():
    mode = sheet(FOUND)
    waveform = mode.phases["stages"].waveform
    assert waveform.currents_a == Reference(**FOUND)
    written = mode.model_dump(mode="json", by_alias=True)
    assert written["phases"]["stages"]["staged"]["currents_a"] == FOUND
    assert Mode.model_validate(written) == mode


def test_planning_holds_an_open_reference():
    cell, mode = battery("lfp_8ah"), sheet(FOUND)
    check(cell, mode, settings(0.1))
    resolver = Resolver(mode, cell.capacity_in_use_ah)
    found = parameters(resolver, mode.phases["stages"].waveform, "phases.stages")
    assert found == {"currents_a": Reference(**FOUND)}


def test_an_open_reference_cannot_be_run():
    with pytest.raises(UserError, match=r"phases\.stages\.currents_a: still to be found by 'staging'"):
        resolve(sheet(FOUND), 8.0)


def test_the_list_put_in_its_place_is_the_list_written_down():
    written = sheet(FOUND).model_dump(mode="json", by_alias=True)
    written["phases"]["stages"]["staged"]["currents_a"] = [16.0, 8.0, 4.0]
    assert resolve(Mode.model_validate(written), 8.0) == resolve(sheet([16.0, 8.0, 4.0]), 8.0)


def test_a_list_of_another_length_than_the_edges_is_refused():
    with pytest.raises(UserError, match="3 edges for 2 currents"):
        check(battery("lfp_8ah"), sheet([16.0, 8.0]), settings(0.1))


@pytest.mark.parametrize("currents", [[], {"from": "staging"}, "stage_1_a"])
def test_what_is_neither_a_list_nor_a_reference_is_refused(currents):
    with pytest.raises(ValueError, match="currents_a"):
        sheet(currents)
