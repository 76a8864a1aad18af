"""`python -m pipeline compare-modes`: charge a battery in several modes and say which is better, in what, by how much.

The page, with the curves side by side, lies in reports/compare_modes; other values are given as KEY=VALUE: a knob or a
condition (frequency_hz=90, initial_soc=0.3), one mode's alone (cv_reflex.frequency_hz=50), or, with a panel, what lies
between it and the battery (weather=half_cloudy_taichung, load.power_w=20).
"""

from __future__ import annotations

import argparse
import io
import json
import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pipeline.charge.comparison import peak_current_a
from pipeline.charge.feasible import notices, remarks
from pipeline.commands import Parser, as_typed, typed
from pipeline.commands.terminal import table_lines
from pipeline.commands.workflow import say
from pipeline.config.choices import parse
from pipeline.config.compose import options
from pipeline.config.naming import joined
from pipeline.errors import UserError, best_matches
from pipeline.experiments.charges.telling import main_quantities
from pipeline.experiments.reporting.announce import lead_to_all
from pipeline.kernel import registry, store
from pipeline.kernel.draft import references
from pipeline.notebook import charges, named
from pipeline.published.wording import plain
from pipeline.report import pages, style, text, traces
from pipeline.report.tables import Cell, ReportTable, to_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.notebook.outcome import NotebookCharge

TEMPLATE = Path(__file__).with_name("compare_modes.html.j2")
DEFAULT_MODES = "cc_cv,cv_pulse,cv_reflex"
_OF_SUPPLY = ("panel", *named.BETWEEN)
_DRAWN = (
    ("Voltage / V", "Voltage [V]", 1.0, ("voltage_min_v", "voltage_max_v")),
    ("Current / A", "Current [A]", 1.0, ("current_min_a", "current_max_a")),
    ("Surface Temperature / degC", "Temperature [°C]", 1.0, None),
    ("soc", "State of charge [%]", 100.0, None),
)


class Measure(NamedTuple):
    """Something in which modes are held against each other.

    `name` is a quantity of the summary, `factor` brings it to `unit`, `of` says in words what it is, `best` what the
    best mode is or does. Less is better unless `more`. A lead below `matters`, in `unit`, is none; where that is
    negative, it is a share of the best number.
    """

    name: str
    of: str
    best: str
    unit: str
    factor: float
    matters: float
    more: bool = False

    def is_clear(self, best: float, second: float) -> bool:
        """Tell whether a number is ahead of the next by what matters."""
        least = self.matters if self.matters > 0.0 else -self.matters * self.factor * abs(best)
        return self.factor * abs(second - best) >= least


def main(arguments: Sequence[str]) -> int:
    """Charge, print the answer and a table, write the page; return 0."""
    parser = Parser(
        prog=typed("compare-modes"),
        description=as_typed(__doc__ or ""),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--battery", required=True, metavar="NAME", help="file of conf/battery; see: batteries")
    parser.add_argument(
        "--panel",
        metavar="NAME",
        help="file of conf/panel or panel of pvlib's databases (see: panels); a supply that gives any power where none",
    )
    parser.add_argument("--modes", default=DEFAULT_MODES, metavar="NAME,...", help="files of conf/modes (%(default)s)")
    parser.add_argument("values", nargs="*", metavar="KEY=VALUE", help="knobs, conditions, parts of the supply")
    given = parser.parse_intermixed_args(arguments)
    modes = given.modes.split(",")
    _check(given.battery, modes)
    choices, words = _sorted(given.values)
    if words and given.panel is None:
        raise UserError(f"override {words[0]}: of the supply of a panel; give --panel NAME beside it")
    fed = None if given.panel is None else _fed(given.panel, words)
    compared = Compared(_charged(given.battery, modes, fed, choices), given.battery, tuple(modes), fed, choices)
    identity = [given.battery, *([given.panel] if given.panel else []), "+".join(modes), *sorted(given.values)]
    page = write(compared, Path(store.REPORTS) / pages.SIDE_BY_SIDE / joined(identity, identity), arguments)
    table = table_lines(_shown(compared.table()))
    for line in (*map(text.prose, compared.answer()), "", *table, "", *map(text.prose, compared.notes())):
        print(line)
    print(f"the page: {page}")
    return 0


def _check(battery: str, modes: Sequence[str]) -> None:
    for option, group, names in (("--battery", "battery", [battery]), ("--modes", "modes", modes)):
        known = options(group)
        for name in names:
            if name not in known:
                raise UserError(f"{option} {name}: no conf/{group}/{name}.yaml; {best_matches(name, known)}")
    if len(set(modes)) < len(modes):
        raise UserError(f"--modes {','.join(modes)}: each mode may stand there once")


def _sorted(values: Sequence[str]) -> tuple[dict[str, Any], list[str]]:
    """Divide KEY=VALUE into knobs and conditions, by name, and overrides of the supply."""
    found: dict[str, Any] = {}
    words = []
    for word, parsed in zip(values, parse(values), strict=True):
        key = parsed.key_or_group
        if key in ("panel", "panel.name", "panel.database"):
            raise UserError(f"override {word}: --panel NAME says which panel")
        if parsed.is_delete():
            raise UserError(f"override {word}: nothing is taken out here; allowed is KEY=VALUE")
        if parsed.is_sweep_override():
            raise UserError(f"override {word}: several values make a sweep; give one of them")
        if key.split(".")[0] in _OF_SUPPLY:
            words.append(word)
        else:
            value = parsed.value()
            found[key.removeprefix("modes.").removeprefix("charge.")] = getattr(value, "text", value)
    return found, words


def _fed(panel: str, words: Sequence[str]) -> named.Fed:
    try:
        return named.fed(panel, words)
    except UserError as error:
        typed = f'override panel.name="{panel}": panel.name'
        raise UserError(str(error).replace(typed, f"--panel {panel}")) from None


def _charged(
    battery: str, modes: Sequence[str], fed: named.Fed | None, choices: Mapping[str, Any]
) -> list[NotebookCharge]:
    """Charge in every mode; what one waits for is found first, by the steps of the study that charges with it."""
    try:
        return charges.side_by_side(battery, modes, panel=fed, **choices)
    except named.NotFound as missing:
        targets = {registry.steps()[step].target for step in missing.steps} - {None}
        if missing.study is None or not targets:
            raise
        # The runner of the workflow is needed for this alone.
        from pipeline.commands.run import main as make

        for target in sorted(map(str, targets)):
            words = [f"study={missing.study}", "-t", target]
            say(f"a mode waits for a value that is found once: {typed(' '.join(words))}")
            if make(words):
                raise UserError(f"what {' and '.join(missing.steps)} finds could not be made; give a number") from None
    return charges.side_by_side(battery, modes, panel=fed, **choices)


class Compared:
    """Charges of one battery in several modes.

    Arguments
    ---------
    found : the charges, in the order of the modes.
    beside : name of the battery's file.
    modes : names of their files.
    fed : what they are fed from; a supply that gives any power where none.
    given : knobs and conditions, as they were given.
    """

    def __init__(
        self,
        found: Sequence[NotebookCharge],
        beside: str,
        modes: tuple[str, ...],
        fed: named.Fed | None,
        given: Mapping[str, Any],
    ) -> None:
        self.charges, self.modes, self.fed, self.given = list(found), modes, fed, given
        self._beside = beside
        self.titles = _told_apart([one.mode.title for one in found], modes)

    @property
    def battery(self) -> Any:
        """Return the battery."""
        return self.charges[0].battery

    @property
    def supply(self) -> str:
        """Return in words what the charges are fed from."""
        return "a supply that gives any power" if self.fed is None else self.fed.told

    def measures(self) -> list[Measure]:
        """Return what the modes are compared in: the time to the highest SOC that all reach, and others."""
        marks = sorted(self.charges[0].settings.soc_marks)
        reached = [mark for mark in marks if all(self._value(f"time_to_soc_{mark:g}_s", one) for one in self.charges)]
        last = f"time_to_soc_{reached[-1]:g}_s" if reached else "end_time_s"
        to = f"to SOC {reached[-1]:g}" if reached else "to the end"
        return [
            Measure(last, f"time {to}", f"is fastest {to}", "h", 1.0 / 3600.0, -0.01),
            Measure("peak_temperature_c", "peak temperature", "stays coolest", "degC", 1.0, 0.2),
            Measure("system_efficiency", "the stored share of what is drawn", "wastes least", "%", 100.0, 0.5, True),
        ]

    def answer(self) -> list[str]:
        """Return sentences that say which mode is better in what, by how much; one a measure."""
        return [self._answer(one) for one in self.measures()]

    def _answer(self, measure: Measure) -> str:
        found = {title: self._value(measure.name, one) for title, one in zip(self.titles, self.charges, strict=True)}
        values = {title: value for title, value in found.items() if value is not None}
        order = sorted(values, key=lambda title: values[title], reverse=measure.more)
        lead = measure.factor * abs(values[order[1]] - values[order[0]]) if len(order) > 1 else 0.0
        listed = ", ".join(f"{title} {plain(measure.factor * values[title], measure.unit, lead)}" for title in order)
        listed += "".join(f", {title} none" for title in found if title not in values)
        if len(order) < 2:
            return f"{measure.of[:1].upper()}{measure.of[1:]}: {listed.removeprefix(', ')}."
        best, second = order[:2]
        if not measure.is_clear(values[best], values[second]):
            return f"No clear difference in {measure.of} between {best} and {second}: {listed}."
        unit = {"degC": "K", "%": "points"}.get(measure.unit, measure.unit)
        share = f" ({100 * abs(values[second] / values[best] - 1.0):.0f} %)" if measure.unit == "h" else ""
        return f"{best} {measure.best}, by {plain(lead, unit)}{share}: {listed}."

    def table(self) -> ReportTable:
        """Return what came of the charges, a row a quantity, a column a mode."""
        marks = [f"time_to_soc_{mark:g}_s" for mark in sorted(self.charges[0].settings.soc_marks)]
        rows: list[tuple[Cell, ...]] = [
            (_words(name), unit, *(None if value is None else factor * value for value in values))
            for name, unit, factor in main_quantities(marks)
            for values in [[self._value(name, one) for one in self.charges]]
        ]
        rows.insert(-6, ("Largest current asked for", "A", *map(_peak_a, self.charges)))
        rows.append(("Ended by", "", *(str(one.summary["end_reason"]) for one in self.charges)))
        header = ("quantity", "unit", *self.titles)
        return ReportTable("modes", "The charges in numbers", "A dash: not reached.", header, tuple(rows))

    def notes(self) -> list[str]:
        """Return what is to be known of the numbers: found values, what was missed, currents that are unusual."""
        start = self.charges[0].settings
        told = [
            f"{self.battery.title}, {self.battery.capacity_in_use_ah:g} Ah, from SOC {start.initial_soc:g} at "
            f"{start.ambient_c:g} degC, fed from {self.supply}."
        ]
        told += [f"battery.{said}." for said in remarks(self.charges[0].battery, start)]
        peaks = {plain(peak, "A") for peak in map(_peak_a, self.charges) if peak is not None}
        if len(peaks) > 1:
            told.append(f"The largest currents that the modes ask for differ: {', '.join(sorted(peaks))}.")
        for name, title, one in zip(self.modes, self.titles, self.charges, strict=True):
            told += [f"{title}: {said}" for said in self._found(name, one)]
            if one.summary["missed"]:
                told.append(f"{title}: {one.summary['missed']}.")
            told += [f"{title}: {said}." for said in notices(one.battery, one.mode, one.settings)]
        return told

    def _found(self, name: str, one: NotebookCharge) -> Iterator[str]:
        """Yield which knobs of a mode are values that a step of a study found."""
        for knob, value in named.written_mode(name, self._beside)[1].items():
            steps = sorted(set(references(value)))
            number = one.mode.knobs.get(knob)
            if steps and isinstance(number, float | int) and not {knob, f"{name}.{knob}"} & set(self.given):
                yield f"{knob} is {number:.4g}, which the step {steps[0]} found in its study; {knob}=... sets another."

    def _value(self, name: str, one: NotebookCharge) -> float | None:
        value = one.summary[name]
        return float(value) if isinstance(value, float | int) and math.isfinite(value) else None

    def draw(self) -> Figure:
        """Draw voltage, current, temperature and SOC over time, the modes together."""
        drawing = style.figure(9.0)
        fields = drawing.subplots(len(_DRAWN), 1, sharex=True)
        marks = style.marks(self.modes)
        for name, one in zip(self.modes, self.charges, strict=True):
            trace, mark = _thinned(one), marks[name]
            hours = trace["Test Time / s"] / 3600.0
            for axes, (column, _, factor, band) in zip(fields, _DRAWN, strict=True):
                axes.plot(hours, factor * trace[column], color=mark.colour, linestyle=mark.line)
                if band is not None and (trace[band[1]] > trace[band[0]]).any():
                    low, high = (trace[each] for each in band)
                    axes.fill_between(hours, low, high, color=mark.colour, alpha=0.12, linewidth=0)
        for axes, (_, words, _, _) in zip(fields, _DRAWN, strict=True):
            axes.set_ylabel(words)
        fields[-1].set_xlabel("Time [h]")
        style.legend(drawing, dict(zip(self.modes, self.titles, strict=True)), marks)
        return drawing

    def curves(self) -> list[traces.Trace]:
        """Return the curves that a reader of the page may zoom into."""
        return [
            traces.Trace(
                name,
                title,
                "modes",
                place,
                one.trace["Test Time / s"].to_numpy(),
                {words: factor * one.trace[column].to_numpy() for column, words, factor, _ in _DRAWN},
            )
            for place, (name, title, one) in enumerate(zip(self.modes, self.titles, self.charges, strict=True))
        ]


def write(compared: Compared, folder: Path, arguments: Sequence[str]) -> Path:
    """Write the page with what it shows beside it; return its path.

    Arguments
    ---------
    arguments : the words of the command, which the page gives again.
    """
    table = compared.table()
    drawn = _svg(compared)
    html = pages.environment(TEMPLATE.parent).get_template(TEMPLATE.name)
    title = f"{compared.battery.title}: {', '.join(compared.titles)}"
    page = html.render(
        title=title,
        command=f"python -m pipeline compare-modes {shlex.join(arguments)}",
        answer=compared.answer(),
        notes=compared.notes(),
        size=pages.size_of(drawn),
        table=table,
    )
    store.write_text(folder / "figures" / "modes.svg", drawn)
    store.write_text(folder / "tables" / f"{table.name}.csv", to_csv(table))
    store.write_text(folder / pages.TRACES, traces.script(compared.curves()))
    store.write_text(folder / "index.html", page)
    question = (
        f"Which of {len(compared.titles)} modes charges {compared.battery.title} fastest, coolest, with least loss?"
    )
    picture = ("figures/modes.svg", pages.size_of(drawn))
    card = pages.short_card(title, question, compared.answer()[0], picture)
    store.write_text(folder / "card.json", json.dumps(card, ensure_ascii=False, indent=1) + "\n")
    lead_to_all(folder.parents[1])
    return folder / "index.html"


def _svg(compared: Compared) -> str:
    """Return the figure as SVG, without date and version; a PNG beside it would take as long again."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    with style.active(), io.StringIO() as file:
        drawing = compared.draw()
        style.typeset(drawing)
        canvas: Any = FigureCanvasSVG(drawing)
        canvas.print_svg(file, metadata={"Date": None, "Creator": None, "Title": "modes"})
        return file.getvalue()


def _thinned(one: NotebookCharge) -> dict[str, Any]:
    """Return the columns of a trace that are drawn, at the points that show their course."""
    drawn = [name for column, _, _, band in _DRAWN for name in (column, *(band or ()))]
    columns = {name: one.trace[name].to_numpy() for name in ("Test Time / s", *drawn)}
    places = traces.thinned(columns["Test Time / s"], [columns[name] for name in drawn])
    return {name: values[places] for name, values in columns.items()}


def _shown(table: ReportTable) -> list[tuple[str, ...]]:
    """Return the cells of a table as texts, its header first."""
    return [
        table.header,
        *((str(name), text.unit(str(unit)), *map(text.number, cells)) for name, unit, *cells in table.rows),
    ]


def _words(name: str) -> str:
    return text.label(name, with_unit=False)


def _peak_a(one: NotebookCharge) -> float | None:
    return peak_current_a(one.mode, one.battery)


def _told_apart(titles: Sequence[str], modes: Sequence[str]) -> list[str]:
    """Return the titles, with the name of the file where two are the same."""
    return [
        title if titles.count(title) == 1 else f"{title} ({mode})" for title, mode in zip(titles, modes, strict=True)
    ]
