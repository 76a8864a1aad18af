"""Figures of the nickel-cadmium study from charges that were really made, and the answer in words."""

import re
from pathlib import Path

import pytest
import yaml

from pipeline.charge.records import Mode
from pipeline.charge.simulate import BENCH, simulate
from pipeline.experiments.trade_off.page import answer, sections, titles, worth
from pipeline.experiments.trade_off.records import TradeOff
from pipeline.experiments.trade_off.summary import quantities, trade_off
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import ModeLabel, ReportData
from tests import making
from tests.charge.samples import ENGINE, battery, settings
from tests.experiments.looking import faults, shows_published
from tests.experiments.network.artefacts import network_half
from tests.experiments.trade_off.test_trade_off import CHOSEN, MODES

CARDS = yaml.safe_load((Path(__file__).parents[3] / "conf" / "report" / "nicd_grnn.yaml").read_text())
OURS = ("nickel_charge", "trade_off", "sensors", "charger", "strings", "over_time", "energy")
NAMES = [name for name, card in CARDS.items() if card["draw"] in OURS]
SHEETS = {"grnn": MODES["net"], "plain_rule": MODES["rule"]} | {
    name: Mode(
        title=name, current_c_rate=rate, phases={"charge": {"constant_current": {}}}, stop={"elapsed_s": 3900 / rate}
    )
    for name, rate in (("constant_4c", 4.0), ("constant_8c", 8.0))
}
SETTINGS = {
    "trade_off": {
        "full_soc": 0.95,
        "conditions": CHOSEN["conditions"],
        "sensors": CHOSEN["sensors"],
    },
    "system": {"battery": {"title": "Ni-Cd 2 x 1.2 V 600 mAh", "capacity_in_use_ah": 0.6}},
}


def write_charge(folder: Path, mode: Mode) -> None:
    cell, output = battery("nicd_2s_600mah"), making.output("charge", folder)
    made = simulate(cell, mode, BENCH, settings(0.02, ambient_c=30.0, sample_interval_s=2.0), ENGINE)
    output.write("trace", made.trace)
    output.rows("summary", made.summary)
    output.write("energy", made.energy)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("nickel")
    inputs = {}
    for comparison in ("stopped", "unstopped"):
        for name, mode in SHEETS.items():
            inputs[f"charge/{comparison}/{name}"] = folder / comparison / name
            write_charge(folder / comparison / name, mode)
    chosen = TradeOff.model_validate(CHOSEN | {"candidate": "grnn", "rule": "plain_rule", "c_rates": [4.0, 8.0]})
    cell = battery("nicd_2s_600mah")
    rows = trade_off(cell, SHEETS, settings(0.5, sample_interval_s=1.0), ENGINE, chosen)
    inputs["trade_off"] = folder / "trade_off"
    output = making.output("trade_off", inputs["trade_off"])
    output.rows("trade_off", rows)
    output.numbers(quantities(rows, chosen))
    inputs |= network_half()
    labels = {name: ModeLabel(name, dict(mode.knobs)) for name, mode in SHEETS.items()}
    return ReportData(making.inputs(inputs), labels, {"stopped": "stopped", "unstopped": "unstopped"}, SETTINGS)


@pytest.mark.parametrize("name", NAMES)
def test_every_figure_draws_and_is_the_same_bytes_twice(name, whole, tmp_path):
    card = FigureCard.model_validate(CARDS[name])
    made = []
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        fresh = ReportData(making.inputs(dict(whole.inputs)), whole.modes, whole.comparisons, whole.settings)
        with style.active():
            drawing = card.drawing().draw(card, fresh)
            paths = style.save(drawing, tmp_path / folder, name)
        made.append([path.read_bytes() for path in paths])
    assert made[0] == made[1]
    with style.active():
        assert faults(drawing) == []
    assert shows_published(drawing) or not any(option.startswith("published") for option in card.options)


@pytest.mark.parametrize("name", NAMES)
def test_a_run_without_what_it_shows_still_has_the_figure(name, whole):
    card = FigureCard.model_validate(CARDS[name])
    kept = {key: folder for key, folder in whole.inputs.items() if key.split("/")[0] in ("network", "surface")}
    if card.draw == "charger":
        kept = {}
    with style.active():
        drawn = card.drawing().draw(card, ReportData(making.inputs(kept), whole.modes, whole.comparisons, {}))
        drawn.draw_without_rendering()


def test_the_stops_stand_where_the_trade_off_says(whole):
    card = FigureCard.model_validate(CARDS["figure_8_8c"])
    with style.active():
        drawn = card.drawing().draw(card, whole)
    said = " ".join(text.get_text() for text in drawn.get_axes()[0].texts)
    table = whole.table("trade_off", "trade_off")
    for stop, words in (("voltage_drop", "−ΔV"), ("timer", "timer")):
        row = (table["stop"] == stop) & (table["c_rate"] == 8.0) & (table["condition"] == "paper")
        assert f"{words}\n{table['end_time_s'][row][0]:.0f} s" in said
    assert "paper\n415 s" in said


def test_the_answer_holds_the_numbers_it_was_made_from(whole):
    found, said = whole.numbers("trade_off"), answer(whole.numbers("trade_off"), titles(whole))
    assert f"{found['network_time_to_full_paper_s']:.0f} s" in said
    assert f"{found['network_peak_paper_c']:.1f} °C" in said
    assert re.match(r"(No|Yes|In 1 of 2 conditions), in this model: the plain rule.* in \d of 2 conditions", said)
    cells = [cell for row in worth(whole).rows for cell in row if isinstance(cell, float)]
    assert found["rule_peak_warm_c"] in cells
    shown = sections(whole, [])
    assert [section.name for section in shown] == ["is-it-worth-it"]
    assert shown[0].text == said


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        ({"a": (100.0, 40.0), "b": (99.0, 41.0)}, "No"),
        ({"a": (100.05, 40.0), "b": (110.0, 30.0)}, "In 1 of 2 conditions"),
        ({"a": (90.0, 45.0)}, "Yes"),
    ],
)
def test_the_answer_follows_the_numbers(rule, words):
    network = dict.fromkeys("ab", (100.0, 45.0))
    found = {
        f"{who}_{part}": value
        for who, charges in (("network", network), ("rule", rule))
        for name, pair in charges.items()
        for part, value in zip((f"time_to_full_{name}_s", f"peak_{name}_c"), pair, strict=True)
    }
    assert answer(found, {"a": "one", "b": "other"}).startswith(f"{words}, in this model")
    assert answer({}, {"a": "one"}) == "The network did not charge the battery in this run."
