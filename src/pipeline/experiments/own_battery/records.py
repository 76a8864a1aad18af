"""The part of the configuration that own measurements take: the file, what is held out of the fit, how it is fitted."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from pipeline.errors import best_matches
from pipeline.record import OwnFile, Record

COLUMNS = ("time", "time_s", "date", "voltage_v", "current_a", "temperature_c", "ambient_c", "mode", "step")
"""The quantities of a measurement, as `measured.columns` and `measured.units` name them."""

NOTHING = ("", "NaN", "nan", "NA", "N/A", "n/a", "#N/A", "null", "NULL", "None", "none", "-", "--", "---")
"""What loggers and tables write where nothing was measured."""

Sign = Literal["auto", "positive_charging", "positive_discharging", "by_mode"]
Between = Literal["auto", "step", "line"]


class Measured(OwnFile):
    """Files that a cycler or a logger wrote, and what they do not say of themselves."""

    file: str = Field(default="", description="the measurement: CSV, Parquet (BDF or plain) or Excel")
    more: tuple[str, ...] = Field(default=(), description="further files of the same battery, written in the same way")
    current: Sign = Field(
        default="auto",
        description="what a positive current means; by_mode: a column says charge, discharge or rest; auto: judged "
        "from how the voltage answers to the current",
    )
    between: Between = Field(
        default="auto",
        description="how current goes from row to row: step, a row's current has flowed since the row before; line, "
        "straight; auto: step where rows are at most 10 s apart",
    )
    sample_interval_s: float | None = Field(
        default=None,
        gt=0,
        description="time from row to row, of a file without a column of times or in place of times that are wrong [s]",
    )
    ambient_c: float | None = Field(
        default=None, ge=-60, le=100, description="temperature of the surroundings, for a file without it [degC]"
    )

    @field_validator("columns", "units")
    @classmethod
    def _known(cls, value: dict[str, str]) -> dict[str, str]:
        for name in value:
            if name not in COLUMNS:
                raise ValueError(f"{name!r} is no quantity of a measurement; {best_matches(name, COLUMNS)}")
        return value

    @property
    def files(self) -> tuple[str, ...]:
        """Return every file, in the order given."""
        return (self.file, *self.more) if self.file else self.more

    def one(self, file: str) -> OwnFile:
        """Return the record of one of the files, empty cells being rows of other sensors."""
        values = {name: getattr(self, name) for name in OwnFile.model_fields}
        return OwnFile.model_validate(values | {"file": file, "missing": (*self.missing, *NOTHING)})


Share = Annotated[float, Field(ge=0, le=1)]


def names_of(file: str) -> tuple[str, str]:
    """Return by what a file may be named: its path as it is given, and the last word of that."""
    return file, Path(file).name


class HeldOut(Record):
    """What the fit may not see until it is done."""

    around_soc: list[Share] = Field(
        default_factory=list, description="states of charge whose pulses and rests are held out [1]"
    )
    width_soc: float = Field(default=0.03, gt=0, le=0.5, description="how near to these a segment has to lie [1]")
    windows_s: list[tuple[float, float]] = Field(default_factory=list, description="from when to when [s]")
    files: list[str] = Field(
        default_factory=list, description="whole files: their paths as they are given, or the last words of these"
    )
    share: float = Field(
        default=0.2, ge=0, le=0.5, description="share of the time held out, at the end, where nothing else is named [1]"
    )

    def takes(self, file: str) -> bool:
        """Tell whether a file is held out whole."""
        return any(name in self.files for name in names_of(file))


class Fit(Record):
    """How the card is fitted, and what is asked of it then."""

    title: str = Field(default="Own battery", min_length=1, description="what the fitted battery is called")
    initial_soc: list[Share] = Field(
        default_factory=list,
        description="state of charge at the start of each file, where it is known: it is then not fitted; else it is "
        "found from the first voltage and fitted [1]",
    )
    pairs: list[Annotated[int, Field(ge=0, le=3)]] = Field(
        default=[0, 1, 2, 3], min_length=1, description="numbers of pairs that are compared [1]"
    )
    side_reaction: Literal["auto", "with", "without"] = Field(
        default="auto", description="auto: a card that has one is also tried without"
    )
    open_circuit_points: int = Field(
        default=0,
        ge=0,
        le=101,
        description="points of a tabulated open-circuit voltage; 0: as the start card has it [1]",
    )
    resistance_points: int = Field(
        default=0, ge=0, le=21, description="points of tabulated resistances; 0: by the data [1]"
    )
    constant_voltage: Literal["current", "voltage"] = Field(
        default="current",
        description="what drives the replay where a charger held the voltage: the measured current, and voltages are "
        "compared, or that voltage up to the charger's current, and currents are compared",
    )
    temperature_dependence: Literal["auto", "with", "without"] = Field(
        default="auto", description="activation energies of the resistances; auto: where the file spans 8 K"
    )
    starts: int = Field(default=4, ge=1, le=50, description="starts of the last fit [1]")
    folds: int = Field(default=3, ge=2, le=10, description="parts of the fitted part, each left out once [1]")
    robust_scale: float = Field(default=3.0, gt=0, description="residual from which it counts less, in its spread [1]")
    held_out: HeldOut = Field(default=HeldOut(), description="what the fit may not see")
    charge_c_rate: float = Field(default=0.5, gt=0, le=20, description="current of the charges that follow [C-rate]")
    charge_voltage_v_cell: float = Field(default=3.45, gt=0, le=10, description="their voltage, for each cell [V]")
    samples: int = Field(default=24, ge=0, le=1000, description="draws from the fit's distribution for the charges [1]")

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if sorted(set(self.pairs)) != self.pairs:
            raise ValueError(f"pairs are {self.pairs}; give each number once, rising")
        return self
