"""Records of a charge: the lab sheet of a mode, the settings of a charge and of the engine."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import (
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from pipeline.charge.waveforms import WAVEFORMS, Limit, Until, Waveform
from pipeline.errors import best_matches
from pipeline.record import Number, Record


class Phase(Record):
    """A waveform, what limits it and what ends it: `{reflex: {}, limit: {voltage_v: 14.4}, until: {soc: 0.99}}`."""

    waveform: Waveform
    limit: Limit = Field(default_factory=Limit, description="voltage limit")
    until: Until = Field(default_factory=Until, description="what ends the phase, whichever comes first")

    @model_validator(mode="wrap")
    @classmethod
    def _one_waveform(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if not isinstance(data, dict) or "waveform" in data:
            return handler(data)
        others = {"limit", "until"}
        found = [key for key in data if key not in others]
        unknown = [key for key in found if key not in WAVEFORMS]
        if unknown:
            raise ValueError(
                f"unknown waveform or key {unknown[0]!r}; {best_matches(unknown[0], {*WAVEFORMS, *others})}"
            )
        if len(found) != 1:
            raise ValueError(f"a phase has one waveform, found {found or 'none'}; known are: {', '.join(WAVEFORMS)}")
        given, kind = data[found[0]], WAVEFORMS[found[0]]
        given = {} if given is None else given
        if not isinstance(given, dict):
            raise ValueError(f"{found[0]} is {given!r}; allowed is a mapping, {{{', '.join(kind.model_fields)}}}")
        unknown = [key for key in given if key not in kind.model_fields]
        if unknown:
            near = best_matches(unknown[0], kind.model_fields)
            raise ValueError(f"{found[0]}.{unknown[0]} is no parameter of this waveform; {near}")
        waveform = kind.model_validate(given)
        return handler({key: data[key] for key in data if key in others} | {"waveform": waveform})

    @model_serializer(mode="wrap")
    def _as_written(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        names = {kind: name for name, kind in WAVEFORMS.items()}
        written: dict[str, Any] = {
            names[type(self.waveform)]: self.waveform.model_dump(mode="json", by_alias=True, exclude_none=True)
        }
        limit, until = self.limit.model_dump(exclude_none=True), self.until.model_dump(exclude_none=True)
        return written | ({"limit": limit} if limit else {}) | ({"until": until} if until else {})


COMPENSATION = (
    "temperature_coefficient_v_per_k_cell",
    "reference_temperature_c",
    "lowest_compensated_c",
    "highest_compensated_c",
)


class Mode(Record):
    """A charging mode as a lab sheet: knobs at the top, phases that refer to them, and what ends the charge."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Number]

    title: str = Field(min_length=1, description="readable name")
    phases: dict[str, Phase] = Field(min_length=1, description="phases by name, in order")
    repeat: int = Field(1, ge=1, le=10_000, description="how often the phases are run through")
    stop: Until = Field(description="what ends the charge, whichever comes first")
    temperature_coefficient_v_per_k_cell: float | None = Field(
        None,
        ge=-0.1,
        le=0.1,
        description="what every voltage held, not exceeded or reached changes by with the battery's temperature, "
        "negative for lead-acid [V/K]",
    )
    reference_temperature_c: float = Field(
        25.0, ge=-40, le=80, description="temperature at which the voltages hold as written [degC]"
    )
    lowest_compensated_c: float | None = Field(None, description="below it they change no further [degC]")
    highest_compensated_c: float | None = Field(None, description="above it they change no further [degC]")

    @model_validator(mode="after")
    def _compensation(self) -> Self:
        low, high = self.lowest_compensated_c, self.highest_compensated_c
        if low is not None and high is not None and low >= high:
            raise ValueError(f"lowest_compensated_c {low:g} is not below highest_compensated_c {high:g}")
        given = {name for name in COMPENSATION if name in self.model_fields_set and getattr(self, name) is not None}
        coefficient, *others = COMPENSATION
        if given and coefficient not in given and given & set(others):
            raise ValueError(f"{sorted(given)[0]} needs {coefficient}; give it, or leave both out")
        return self

    @model_serializer(mode="wrap")
    def _as_given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        written: dict[str, Any] = handler(self)
        absent = self.temperature_coefficient_v_per_k_cell is None
        return {key: value for key, value in written.items() if key not in COMPENSATION or not absent}

    @property
    def knobs(self) -> dict[str, Number]:
        """Return the numbers that stand at the top of the sheet, by name."""
        return dict(self.__pydantic_extra__ or {})


class Window(Record):
    """A stretch of the charge to be kept at full resolution."""

    start_s: float = Field(ge=0, description="start [s]")
    length_s: float = Field(gt=0, description="length [s]")


class ChargeSettings(Record):
    """The conditions of a charge and what is kept of it."""

    initial_soc: float = Field(ge=0, lt=1, description="state of charge at the start [1]")
    ambient_c: float = Field(ge=-40, le=80, description="ambient temperature [degC]")
    initial_temperature_c: float | None = Field(
        None, ge=-40, le=80, description="temperature of the battery at the start; the ambient's where not given [degC]"
    )
    sample_interval_s: float = Field(10.0, ge=1e-3, description="interval of the trace [s]")
    soc_marks: list[float] = Field(default_factory=list, description="states of charge whose times are reported [1]")
    windows: list[Window] = Field(default_factory=list, description="stretches kept at full resolution")

    @property
    def start_c(self) -> float:
        """Return the temperature of the battery at the start [degC]."""
        return self.ambient_c if self.initial_temperature_c is None else self.initial_temperature_c

    @model_validator(mode="after")
    def _marks(self) -> Self:
        for mark in self.soc_marks:
            if not 0.0 < mark < 1.0:
                raise ValueError(f"soc_marks has {mark:g}; each must lie between 0 and 1")
        return self


class EngineSettings(Record):
    """How the engine computes."""

    driver: Literal["auto", "edge", "averaged"] = Field(
        "auto",
        description="from edge to edge, or strides over many periods; auto: strides above 2 Hz; under any of them what "
        "has no periods, and what is watched for a falling voltage or a rising rate, goes from edge to edge",
    )
    tolerance: float = Field(1e-6, gt=1e-13, le=1e-3, description="error of a step relative to current and voltage [1]")
    maximum_step_s: float = Field(
        60.0, ge=1e-3, le=3600, description="longest step; strides over periods take up to twice that [s]"
    )
    maximum_steps: int = Field(
        200_000_000, ge=1, le=10_000_000_000, description="steps after which a charge is given up"
    )
