"""Days in the sun on the page: what each came to, as sentences, tables and figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pipeline.experiments.days.numbers import charged, weathers
from pipeline.report.pages import PageFigure, PageSection
from pipeline.report.tables import Cell, ReportData, ReportTable, plain, sentence
from pipeline.report.text import ended
from pipeline.report.traces import Trace

LABELS = ("day",)
_HOUR_S = 3600.0
_ROWS = (
    ("irradiation_kwh_m2", "light on the panel / kWh/m²", 1.0),
    ("sun_wh", "that light at the panel's standard efficiency / Wh", 1.0),
    ("panel_wh", "lost to warm cells and low light / Wh", 1.0),
    ("tracker_wh", "lost off the maximum power point / Wh", 1.0),
    ("curtailed_wh", "not drawn: neither load nor battery needs it / Wh", 1.0),
    ("boost_wh", "heat of the boost converter / Wh", 1.0),
    ("load_wh", "load / Wh", 1.0),
    ("buck_wh", "heat of the buck converter / Wh", 1.0),
    ("resistor_wh", "discharge resistor / Wh", 1.0),
    ("battery_wh", "heat of the battery / Wh", 1.0),
    ("stored_wh", "stored in the battery / Wh", 1.0),
    ("unserved_wh", "demanded by the load, not supplied / Wh", 1.0),
    ("end_soc", "state of charge at last light", 1.0),
    ("ended_clock_s", "ended at / h, local time", _HOUR_S),
    ("charging_s", "time charging, pauses of pulses left out / h", _HOUR_S),
    ("current_limited_s", "of it at the current limit / h", _HOUR_S),
    ("voltage_limited_s", "of it at the voltage limit / h", _HOUR_S),
    ("supply_limited_s", "of it at the limit of the supply / h", _HOUR_S),
    ("peak_temperature_c", "highest battery temperature / °C", 1.0),
    ("end_temperature_c", "battery temperature at last light / °C", 1.0),
    ("mean_ambient_c", "air, mean of the day / °C", 1.0),
    ("switchings", "switchings", 1.0),
)
_STATES = {"off": "off", "mode_1": "Mode 1", "mode_2": "Mode 2", "ended": "ended"}


_TRACED = {
    "Irradiance [W/m²]": ("irradiance_w_m2", 1.0),
    "Drawn from the panel [W]": ("drawn_w", 1.0),
    "Curtailed [W]": ("curtailed_w", 1.0),
    "Voltage [V]": ("voltage_v", 1.0),
    "Current [A]": ("current_a", 1.0),
    "Temperature [°C]": ("temperature_c", 1.0),
    "State of charge [%]": ("soc", 100.0),
}


def traces(data: ReportData) -> Iterator[Trace]:
    """Yield the course of every day in the sun for the explorer, time from first light."""
    for name, title in weathers(data).items():
        for mode in charged(data, name):
            course = data.table(f"day/{name}/{mode}", "trace")
            quantities = {told: factor * course[column] for told, (column, factor) in _TRACED.items()}
            mark = list(data.modes).index(mode)
            yield Trace(
                f"day/{name}/{mode}", data.modes[mode].title, f"day, {title}", mark, course["time_s"], quantities
            )


def sections(data: ReportData, figures: Sequence[PageFigure]) -> list[PageSection]:
    """Return the section on days in the sun; none where the run has none.

    Arguments
    ---------
    figures : those of this experiment that the paper does not have.
    """
    if not weathers(data):
        return []
    shown = [numbers(data), switchings(data), *files(data), *gaps(data)]
    title = f"From sun to battery: {data.settings['day']['title']}"
    return [PageSection("days-in-the-sun", title, text(data), shown, figures)]


def numbers(data: ReportData) -> ReportTable:
    """Return the numbers of every day: a row per weather and quantity, a column per mode."""
    rows: list[tuple[Cell, ...]] = []
    modes = [mode for mode in data.modes if any(mode in charged(data, name) for name in weathers(data))]
    for name, title in weathers(data).items():
        sky = data.numbers(f"weather/{name}")
        found = {mode: sky | data.numbers(f"day/{name}/{mode}") for mode in charged(data, name)}
        for quantity, words, scale in _ROWS:
            values = (found.get(mode, {}).get(quantity) for mode in modes)
            rows.append((title, words, *(None if value is None else value / scale for value in values)))
    return ReportTable(
        "days",
        "The days in numbers",
        "The parts of the light at the panel's standard efficiency add up to it. A dash: not ended by last light, which"
        " stands in place of a mode's time limit.",
        ("day", "quantity", *(data.modes[mode].title for mode in modes)),
        tuple(rows),
        grouped=True,
    )


def switchings(data: ReportData) -> ReportTable:
    """Return every change of the switches, with the reason."""
    rows: list[tuple[Cell, ...]] = []
    for name, title in weathers(data).items():
        for mode in charged(data, name):
            found = data.table(f"day/{name}/{mode}", "switching")
            for row in range(len(found["time_s"])):
                shares = (f"{100.0 * float(found[f's{switch}_share'][row]):g} %" for switch in (2, 3, 4))
                rows.append(
                    (
                        title,
                        data.modes[mode].title,
                        clock(float(found["clock_s"][row])),
                        _STATES.get(str(found["after"][row]), str(found["after"][row])),
                        str(found["reason"][row]),
                        *shares,
                        plain(found["pulses_hz"][row]) or None,
                    )
                )
    return ReportTable(
        "day_switchings",
        "When the switches change, and why",
        "Shares of the time for which switches S2, S3 and S4 are closed from then on. Pauses stop a phase's clock.",
        ("day", "mode", "local time", "state", "reason", "S2", "S3", "S4", "pulses / Hz"),
        tuple(rows),
        grouped=True,
    )


def gaps(data: ReportData) -> list[ReportTable]:
    """Return the table of the gaps in files of measured weather; none where there are none."""
    rows: list[tuple[Cell, ...]] = []
    for name, title in weathers(data).items():
        found = data.table(f"weather/{name}", "gaps")
        for start_s, length_s, filled in zip(found["clock_s"], found["length_s"], found["filled"], strict=True):
            rows.append((title, clock(float(start_s)), plain(length_s), str(filled)))
    if not rows:
        return []
    return [
        ReportTable(
            "day_gaps",
            "Gaps in measured weather",
            "Stretches of the file for which no row holds, and what stands in for them.",
            ("day", "from, local time", "length / s", "filled"),
            tuple(rows),
            grouped=True,
        )
    ]


def files(data: ReportData) -> list[ReportTable]:
    """Return the table of what the files of weathers and load were taken for; none where there are none."""
    found: dict[tuple[str, str], None] = {}
    for name, title in weathers(data).items():
        found |= dict.fromkeys((f"weather: {title}", note) for note in data.table(f"weather/{name}", "notes")["note"])
        notes = data.table(f"daylight/{name}", "notes")["note"]
        found |= dict.fromkeys((f"load: {data.settings['day']['load']}", note) for note in notes)
    if not found:
        return []
    return [
        ReportTable(
            "day_files",
            "The files that were brought",
            "What each file was taken for, and what was done to its values; every guess is a key of the configuration.",
            ("file", "what was found"),
            tuple(found),
            grouped=True,
        )
    ]


def clock(seconds: float) -> str:
    """Return seconds since midnight as hours, minutes and seconds."""
    whole = round(seconds) % 86400
    return f"{whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}"


def text(data: ReportData) -> str:
    """Return what the days come to in sentences, every number of which was computed."""
    settings = data.settings["day"]
    sentences = [
        f"Not in the paper: {settings['title']} under {len(weathers(data))} skies, from "
        f"{100.0 * settings['initial_soc']:g} % charged at first light to last light. What the panel could give at its "
        "efficiency of standard conditions is followed to the battery."
    ]
    for name, title in weathers(data).items():
        sky, modes = data.numbers(f"weather/{name}"), charged(data, name)
        found = {mode: data.numbers(f"day/{name}/{mode}") for mode in modes}
        parts = [_fate(data, name, mode, found[mode]) for mode in modes]
        first = found[modes[0]]
        share = 100.0 * first["stored_wh"] / first["sun_wh"] if first["sun_wh"] else 0.0
        unused = 100.0 * first["curtailed_wh"] / first["sun_wh"] if first["sun_wh"] else 0.0
        sentences.append(
            f"{sentence(title)} day, {sky['irradiation_kwh_m2']:.2f} kWh/m²: {'; '.join(parts)}. With "
            f"{data.modes[modes[0]].title}, {share:.0f} % of it is stored, and {unused:.0f} % is not needed."
        )
        sentences += [
            f"{data.modes[mode].title}: {told}."
            for mode in modes
            for told in data.table(f"day/{name}/{mode}", "missed")["missed"]
        ]
        if sky.get("gaps"):
            sentences.append(
                f"Its file has {sky['gaps']:.0f} gaps, {sky['gap_s']:.0f} s together; {sky['dark_gaps']:.0f} of them, "
                f"{sky['dark_gap_s']:.0f} s, are too long to be interpolated and count as dark."
            )
    sentences.append(
        "The load is served first, and nothing leads from the battery back to the bus: what the sun does not give the "
        "load, it does not get."
    )
    sentences.append(_bus(data))
    return " ".join(sentences)


def _bus(data: ReportData) -> str:
    """Say what becomes of the sun while a pulse pauses."""
    settings = data.settings["day"]
    farad, swing = settings.get("bus_capacitance_f", 0.0), settings.get("bus_swing_share", 0.0)
    if not farad * swing:
        return "The bus is taken to store nothing, so that sun is unused while a pulse pauses."
    return (
        f"While a pulse pauses, the {1e6 * farad:.0f} µF on the bus keep what a swing of its voltage by "
        f"{100.0 * swing:g} % can take, for the next pulse."
    )


def _fate(data: ReportData, weather: str, mode: str, found: Mapping[str, float]) -> str:
    title = data.modes[mode].title
    if "ended_clock_s" in found:
        changes = data.table(f"day/{weather}/{mode}", "switching")
        why = next(str(r) for r, to in zip(changes["reason"], changes["after"], strict=True) if str(to) == "ended")
        return f"{title} ends at {clock(found['ended_clock_s'])[:5]} ({ended(why)})"
    return f"{title} reaches {100.0 * found['end_soc']:.1f} % by last light"
