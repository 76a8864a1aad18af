"""What a report is made of; light to import."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, model_validator

from pipeline.errors import best_matches
from pipeline.record import Record


class NoOptions(Record):
    """A figure with nothing to choose."""


class OverTimeOptions(Record):
    """A quantity over the whole charge."""

    quantity: Literal["current", "voltage", "soc", "temperature"]
    time_in: Literal["h", "min", "s"] = Field(default="h", description="unit of the axis of time")


class EnlargedOptions(Record):
    """A quantity at full resolution, in the windows of the charge."""

    quantity: Literal["current", "voltage"]
    windows: tuple[int, ...] = Field(default=(), description="which windows, from 0; empty for all of them")


class SwitchedOptions(Record):
    """A quantity about the steps of the pulses, switch by switch."""

    quantity: Literal["current", "voltage"]
    window: int = Field(default=0, ge=0, description="which window, from 0")


class WaveformOptions(Record):
    """The waveform of one mode, from its knobs."""

    mode: str = Field(default="cv_reflex", min_length=1, description="name of the mode")
    periods: float = Field(default=2.0, ge=1, le=10, description="how many periods are drawn [1]")


class ConvergenceOptions(Record):
    """The course of a search."""

    quantity: Literal["frequency", "ise"]
    runs: str = Field(default="published_protocol", min_length=1, description="search whose runs are drawn one by one")
    band: str = Field(default="swarm_published", min_length=1, description="search whose runs make the band behind")
    oracle: str = Field(default="sweep", min_length=1, description="search whose end is where they should end")


class EffectOptions(Record):
    """Searches held against each other."""

    searches: dict[str, str] = Field(min_length=2, description="name of a search -> what it is called here")


class NickelChargeOptions(Record):
    """A charge of a nickel battery, its signs of full marked."""

    mode: str = Field(min_length=1, description="name of the mode")
    show: tuple[Literal["current", "voltage", "temperature", "rate", "soc"], ...] = Field(
        default=("voltage", "temperature", "rate"), min_length=1, description="quantities, one field each"
    )
    c_rate: float | None = Field(default=None, gt=0, description="constant current whose stops are marked [C-rate]")
    published_stop_s: float | None = Field(default=None, gt=0, description="when the paper would stop it [s]")


class ControllerOptions(Record):
    """One of the paper's diagrams of the charger."""

    part: Literal["current_source", "loop"]
    mode: str = Field(default="grnn", min_length=1, description="mode whose controller is drawn")


class FunctionConvergenceOptions(Record):
    """Searches on test functions, run by run."""

    functions: tuple[str, ...] = Field(min_length=1, description="names of the functions, a column each")
    placements: tuple[Literal["centred", "shifted", "rotated"], ...] = Field(
        default=("centred", "shifted", "rotated"), min_length=1, description="a row each"
    )
    searches: dict[str, str] = Field(min_length=1, description="name of a search -> what it is called here")


class FunctionPlacementsOptions(Record):
    """Searches on test functions, by where the minimum is."""

    searches: dict[str, str] = Field(min_length=1, description="name of a search -> what it is called here")


class ChargeOptions(Record):
    """One charge."""

    mode: str = Field(min_length=1, description="name of the mode")


class StageTemperatureOptions(ChargeOptions):
    """A staged charge, and what is printed about it."""

    highest_k: float = Field(gt=0, description="highest temperature rise printed [K]")
    after_three_k: float = Field(gt=0, description="highest rise of the first three stages printed [K]")
    end_s: float = Field(gt=0, description="charging time printed [s]")


class StageCasesOptions(Record):
    """Staged charges that matter."""

    cases: dict[str, str] = Field(min_length=1, max_length=7, description="name of a case -> what it is called here")


class StageSearchOptions(Record):
    """Searches for stage currents."""

    weights: str = Field(min_length=1, description="name of the weights")
    searches: dict[str, str] = Field(min_length=1, max_length=7, description="name of a search -> what it is called")


class CheckOptions(Record):
    """The lines of a check of the engine."""

    check: str = Field(min_length=1, description="name of the check")
    columns: int = Field(default=2, ge=1, le=4, description="fields in a row")


class CircuitOptions(Record):
    """One of the paper's diagrams of the system."""

    part: Literal["system", "mode_1", "mode_2", "architecture"]
    mode: str = Field(default="cv_reflex", min_length=1, description="mode whose discharge the resistor is drawn for")


class DayBarsOptions(Record):
    """Days in the sun, split into parts."""

    quantity: Literal["energy", "time"] = Field(default="energy", description="what the bars split")


DRAWINGS: dict[str, type[Record]] = {
    "algorithm": NoOptions,
    "array_against_factorial": NoOptions,
    "calibration_gains": NoOptions,
    "cell_curves": NoOptions,
    "charge_course": ChargeOptions,
    "charger": ControllerOptions,
    "circuit": CircuitOptions,
    "convergence": ConvergenceOptions,
    "control_loop": NoOptions,
    "day_bars": DayBarsOptions,
    "day_course": NoOptions,
    "energy": NoOptions,
    "efficiency_map": NoOptions,
    "enlarged": EnlargedOptions,
    "frequency_map": NoOptions,
    "function_convergence": FunctionConvergenceOptions,
    "function_placements": FunctionPlacementsOptions,
    "level_effects": NoOptions,
    "logistic_map": NoOptions,
    "loss_over_frequency": NoOptions,
    "map_disorder": NoOptions,
    "network_convergence": NoOptions,
    "network_selections": NoOptions,
    "network_size": NoOptions,
    "network_surface": NoOptions,
    "nickel_charge": NickelChargeOptions,
    "over_time": OverTimeOptions,
    "panel_curves": NoOptions,
    "reflex_waveform": WaveformOptions,
    "search_effects": EffectOptions,
    "sensors": NoOptions,
    "shaded_string": NoOptions,
    "stage_currents": StageCasesOptions,
    "stage_search_course": StageSearchOptions,
    "stage_search_ends": StageSearchOptions,
    "stage_temperature": StageTemperatureOptions,
    "strings": NoOptions,
    "supply": NoOptions,
    "switched_edges": SwitchedOptions,
    "thevenin": NoOptions,
    "time_rise_front": StageCasesOptions,
    "tracker_efficiency": NoOptions,
    "tracker_ramp": NoOptions,
    "trade_off": NoOptions,
    "two_cells": NoOptions,
    "validation_differences": CheckOptions,
    "validation_orders": CheckOptions,
}
"""Every module under `figures` and the record of its options."""


Read = Literal[
    "modes", "system", "algorithm", "battery", "stage_search", "panel", "supply", "chaos", "objective", "tuning",
    "search", "surface", "network", "network_size", "network_kernels", "functions", "charge", "switched", "trade_off",
    "weather", "day", "staging_search", "staging", "front", "second_charge", "tracking", "converters", "validation",
]  # fmt: skip
"""What a figure may read."""


class FigureCard(Record):
    """One figure of a report; its identifier, the key it stands under, is also its file name."""

    draw: str = Field(description="module under pipeline.report.figures that draws it")
    paper: str = Field(default="", description="its number in the paper; empty for a figure of our own")
    title: str = Field(min_length=1, description="title, for people")
    caption: str = Field(min_length=1, description="what it shows; also its text for those who cannot see it")
    reads: tuple[Read, ...] = Field(
        description="the steps whose artefacts it reads; modes: the knobs of the modes; system: panel, converters, "
        "load and battery as configured; algorithm: the settings of the search; battery: the battery as configured; "
        "stage_search: the settings of the search for stage currents that is used; trade_off: its settings too; "
        "second_charge: the charges of the second battery, without which the figure is left out"
    )
    comparison: str | None = Field(default=None, description="the only comparison it shows; all of them without")
    options: dict[str, Any] = Field(default_factory=dict, description="what the drawing module lets one choose")

    @model_validator(mode="after")
    def _drawable(self) -> FigureCard:
        if self.draw not in DRAWINGS:
            raise ValueError(f"draw is {self.draw!r}, which draws nothing; {best_matches(self.draw, DRAWINGS)}")
        self.chosen()
        return self

    def chosen(self) -> Record:
        """Return the options as the record the drawing module declares."""
        return DRAWINGS[self.draw](**self.options)
