"""The tables of own measurements, and the numbers that the fit finds."""

from __future__ import annotations

from pipeline.kernel.tables import NOTES, NUMBERS, Column, Table, TableFile
from pipeline.quantity import Vocabulary

_FILE = Column("file", "1", "number of the file, from 0", "integer")
_TIME = Column("time_s", "s", "time since the first row of the file")
SERIES = Table(
    "own_series",
    "The measurement in order, a row per row with a voltage",
    (
        _FILE,
        Column("row", "1", "number of the row in the file", "integer"),
        _TIME,
        Column("voltage_v", "V", "voltage of the battery"),
        Column("current_a", "A", "current into the battery; positive when charging"),
        Column("temperature_c", "degC", "temperature of the battery", optional=True),
        Column("ambient_c", "degC", "temperature of the surroundings", optional=True),
        Column("step", "1", "number of the cycler's step; -1 where there is none", "integer"),
        Column("jumps", "", "whether the row's current has flowed since the row before", "truth"),
        Column("held_out", "", "whether the fit may not see it", "truth"),
    ),
)
SEGMENTS = Table(
    "own_segments",
    "Rests, pulses, constant currents and voltages of the measurement, a row per segment",
    (
        _FILE,
        Column("kind", "", "rest, pulse, constant current, constant voltage, other", "text"),
        Column("start_s", "s", "when it begins"),
        Column("length_s", "s", "how long it is"),
        Column("current_a", "A", "mean current"),
        Column("charge_ah", "Ah", "charge put in"),
        Column("soc", "1", "state of charge at its start, counted with the capacity of the start card"),
        Column("start_v", "V", "voltage of its first row"),
        Column("end_v", "V", "voltage of its last row"),
        Column("first", "1", "its first row in the series of the file", "integer"),
        Column("last", "1", "its last row", "integer"),
    ),
)
FORESIGHT = Table(
    "own_foresight",
    "What the measurement can tell, before any fit",
    (
        Column("quantity", "", "what would be found", "text"),
        Column("told", "", "yes, in part, no", "text"),
        Column("why", "", "what speaks for or against it", "text"),
        Column("test", "", "what would tell it", "text"),
    ),
)
FILES = Table(
    "own_files",
    "The files, a row each",
    (
        _FILE,
        Column("name", "", "its name", "text"),
        Column("rows", "1", "rows used", "integer"),
        Column("charge_in_ah", "Ah", "charge put in"),
        Column("charge_out_ah", "Ah", "charge taken out"),
        Column("initial_soc", "1", "state of charge at its first row, before the fit"),
        Column("stated", "", "whether that was stated", "truth"),
        Column("ambient_c", "degC", "temperature of the surroundings where the file has none"),
    ),
)
READ = {
    "series": TableFile("series.parquet", SERIES, time="time_s"),
    "segments": TableFile("segments.parquet", SEGMENTS),
    "foresight": TableFile("foresight.parquet", FORESIGHT),
    "files": TableFile("files.parquet", FILES),
    **NOTES,
}

_LOOSE = {"*": 1e-2}
STRUCTURES = Table(
    "own_structures",
    "Structures of the card, compared by cross-validation inside the fitted part",
    (
        Column("structure", "", "what it has", "text"),
        Column("unknowns", "1", "numbers fitted", "integer"),
        Column("blocks", "1", "stretches that were left out, each once", "integer"),
        Column("left_out_v", "V", "typical error of the voltage in a stretch that was left out", optional=True),
        Column("seen_v", "V", "error of the voltage over all the fit saw"),
        Column("chosen", "", "the simplest within the noise of the best", "truth"),
    ),
)
PARAMETERS = Table(
    "own_parameters",
    "The numbers of the card, fitted and not",
    (
        Column("path", "", "key path in the card", "text"),
        Column("soc", "1", "state of charge of a point of a table", optional=True),
        Column("unit", "", "unit of the values", "text"),
        Column("start", "see unit", "on the start card"),
        Column("value", "see unit", "on the fitted card"),
        Column("low", "see unit", "lower end of the 95 % interval", optional=True),
        Column("high", "see unit", "upper end", optional=True),
        Column("identified", "", "whether the measurement tells it", "truth"),
        Column("how", "", "how it was found, or why it was not", "text"),
    ),
)
ERRORS = Table(
    "own_errors",
    "Simulated less measured, over every row of the measurement",
    (
        Column("part", "", "fit or held out", "text"),
        _FILE,
        Column("quantity", "", "voltage, temperature, or current where a held voltage drives the replay", "text"),
        Column("unit", "", "unit of the errors", "text"),
        Column("rmse", "see unit", "root of the mean square"),
        Column("p95", "see unit", "95th percentile of the magnitude"),
        Column("largest", "see unit", "largest magnitude"),
        Column("at_s", "s", "where that is"),
        Column("rows", "1", "rows", "integer"),
    ),
)
LIMITS = Table(
    "own_limits",
    "What limits the prediction of files that were held out whole: its error with one part of the card found from them",
    (
        _FILE,
        Column("freed", "", "what was found from the held-out file alone", "text"),
        Column("rmse_v", "V", "error of the voltage then, root of the mean square"),
    ),
)
OVERLAY = Table(
    "own_overlay",
    "Measured and simulated, on the rows that the fit uses",
    (
        _FILE,
        _TIME,
        Column("current_a", "A", "current into the battery"),
        Column("simulated_a", "A", "current replayed: the measured one, but where a held voltage drives the replay"),
        Column("measured_v", "V", "voltage measured"),
        Column("simulated_v", "V", "voltage simulated"),
        Column("measured_c", "degC", "temperature measured", optional=True),
        Column("simulated_c", "degC", "temperature simulated"),
        Column("soc", "1", "state of charge simulated"),
        Column("held_out", "", "whether the fit did not see it", "truth"),
    ),
)
SAMPLES = Table(
    "own_samples",
    "Draws from the fit's distribution",
    (
        Column("sample", "1", "number of the draw", "integer"),
        Column("path", "", "key path in the card", "text"),
        Column("value", "see path", "its value"),
    ),
)
FITTED_NUMBERS = Vocabulary(
    {
        "fit_voltage_rmse_v": ("V", "error of the voltage over the fitted part"),
        "held_out_voltage_rmse_v": ("V", "error of the voltage over what was held out"),
        "fit_temperature_rmse_k": ("K", "error of the temperature over the fitted part"),
        "held_out_temperature_rmse_k": ("K", "error of the temperature over what was held out"),
        "fit_current_rmse_a": ("A", "error of the current at held voltages over the fitted part"),
        "held_out_current_rmse_a": ("A", "error of the current at held voltages over what was held out"),
        "unknowns": ("1", "numbers fitted in the end"),
        "rows": ("1", "rows of voltage that the fit used"),
        "effective_rows": ("1", "independent rows that these are worth"),
        "starts_together": ("1", "share of the starts that came to within 1 % of the best cost"),
        "lowest_soc": ("1", "lowest state of charge of the measurement"),
        "highest_soc": ("1", "highest state of charge of the measurement"),
        "highest_c_rate": ("C-rate", "largest current of the measurement over the capacity"),
        "lowest_temperature_c": ("degC", "lowest temperature of the measurement"),
        "highest_temperature_c": ("degC", "highest temperature of the measurement"),
    }
)
FITTED = {
    "structures": TableFile("structures.parquet", STRUCTURES, elsewhere=_LOOSE),
    "parameters": TableFile("parameters.parquet", PARAMETERS, elsewhere=_LOOSE),
    "errors": TableFile("errors.parquet", ERRORS, elsewhere=_LOOSE),
    "limits": TableFile("limits.parquet", LIMITS, elsewhere=_LOOSE),
    "overlay": TableFile("overlay.parquet", OVERLAY, time="time_s", elsewhere=_LOOSE),
    "samples": TableFile("samples.parquet", SAMPLES, elsewhere=_LOOSE),
    **NUMBERS,
}

CHARGED = Table(
    "own_charges",
    "Charges of the fitted battery with the uncertainty of the fit",
    (
        Column("mode", "", "name of the mode", "text"),
        Column("quantity", "", "what came of the charge", "text"),
        Column("unit", "", "unit of the values", "text"),
        Column("value", "see unit", "of the fitted card", optional=True),
        Column("low", "see unit", "2.5th percentile over draws from the fit's distribution", optional=True),
        Column("high", "see unit", "97.5th percentile", optional=True),
        Column("draws", "1", "draws that came to a value", "integer"),
    ),
)
CHARGES = {"charges": TableFile("charges.parquet", CHARGED, elsewhere=_LOOSE), **NOTES}
