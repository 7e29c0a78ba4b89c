"""What the explorer lets one change: its fields, with unit, allowed range and reason if fixed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.light import SolarModel
from sizing.design import variable_keys
from sizing.design_space import Range
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.parameters import parameter, parameter_value, unit_text
from solar.names import CORRECTION_NAMES, MODELS
from solar.schema import significant, spell

LATITUDE, DAY = "mission.latitude_deg", "mission.day_of_year"
ALTITUDE, WIND = "mission.altitude_m", "mission.wind_m_per_s"

Group = Literal["place", "design", "payload", "technology", "requirement"]

# Field -> group and step, in the order of the page; numbers between two steps are allowed as well.
_GROUPS: dict[Group, dict[str, float]] = {
    "place": {
        "mission.clearness": 0.01,
        ALTITUDE: 10.0,
        "mission.climb.ceiling_m": 10.0,
        WIND: 0.1,
    },
    "design": {
        "airframe.wingspan_m": 0.01,
        "airframe.aspect_ratio": 0.1,
        "airframe.aerodynamics.lift_coefficient": 0.01,
        "battery.mass_kg": 0.01,
        "modules.area_m2": 0.01,
    },
    "payload": {
        "mission.payload.mass_kg": 0.01,
        "mission.payload.power_w": 0.1,
        "power.avionics_w": 0.1,
    },
    "technology": {
        "modules.efficiency_stc": 0.001,
        "modules.mppt_efficiency": 0.001,
        "airframe.propulsion.motor_efficiency": 0.001,
        "airframe.propulsion.propeller_efficiency": 0.001,
        "battery.specific_energy_wh_per_kg": 1.0,
    },
    "requirement": {"mission.required_excess_time_h": 0.1},
}
_ABOUT_LATITUDE = "North positive. It sets how high the sun climbs and how long the night is."
_ABOUT_DAY = (
    "1 is 1 January, 365 is 31 December. The day repeats itself: the date does not advance."
)
_OF_PERCENTILE = "that of percentile {:g} at each place, date and altitude; among the numbers above"
_MEASURED = "fixed: mass and power of this airframe are measured"
_SLIDER_FROM, _SLIDER_TO = 0.3, 2.5  # of a design variable's first value, for a sensitive slider
_PAYLOAD_OF_MASS, _PAYLOAD_OF_LOAD = 0.5, 1.0  # of total mass and load: far ends of the sliders
_PAYLOAD_BEYOND = 20.0  # times the slider's end: what a sizing may find


@dataclass(frozen=True)
class Field:
    """A number that can be changed.

    ``key``: in the aircraft's file, or behind ``mission.`` in the mission's. ``group``: where it
    stands on the page. ``label``, ``unit``: for people; the unit is empty for a number without one.
    ``value``: at the start. ``minimum``, ``maximum``: range that is allowed, ends included.
    ``slider``: ends of the slider, within that range. ``step``: of the slider. ``fixed``: why it
    cannot be changed; empty if it can. ``about``: what it is and does.
    """

    key: str
    group: Group
    label: str
    unit: str
    value: float
    minimum: float
    maximum: float
    slider: tuple[float, float]
    step: float
    fixed: str = ""
    about: str = ""

    @property
    def whole(self) -> bool:
        """Whether only whole numbers are allowed."""
        return self.key == DAY

    @property
    def allowed(self) -> str:
        """Range in words."""
        kind = "a whole number" if self.whole else "a number"
        unit = f" {self.unit}" if self.unit else ""
        return f"{kind} from {spell(self.minimum)} to {spell(self.maximum)}{unit}"

    def mistake(self, value: object) -> str:
        """Return what is wrong with a number; empty if nothing is."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            return "must be a number"
        if not self.minimum <= value <= self.maximum:  # which no NaN is
            return "is out of range"
        if self.whole and value != int(value):
            return "must be a whole number"
        if self.fixed and value != self.value:
            return f"cannot be changed; {self.fixed}"
        return ""

    def to_dict(self) -> dict[str, Any]:
        """Return the field for the page."""
        return {**vars(self), "whole": self.whole, "allowed": self.allowed}


@dataclass(frozen=True)
class Option:
    """A name that may be chosen; ``reason`` says why it may not, if so."""

    name: str
    label: str
    reason: str = ""


@dataclass(frozen=True)
class Choice:
    """A name among some.

    ``key``, ``label``, ``value``: as for :class:`Field`.
    """

    key: str
    label: str
    value: str
    options: tuple[Option, ...]

    @property
    def allowed(self) -> str:
        """Names that may be chosen."""
        return ", ".join(option.name for option in self.options if not option.reason)

    def mistake(self, value: object) -> str:
        """Return what is wrong with a name; empty if nothing is."""
        reasons = (option.reason for option in self.options if option.name == value)
        return next(reasons, "is not one of the names")


_CORRECTION_LABELS = {
    "none": "none",
    "report": "report – measured in one flight",
    "loiter": "loiter – full model on the path",
}


def fields_of(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, at: tuple[float, int]
) -> dict[str, Field | Choice]:
    """Return the fields of an aircraft on a mission by their keys.

    ``at``: latitude [deg] and day of year at the start. Returns in the order of the page.
    """
    lacking = ""
    if aircraft.modules.geometry is None:
        lacking = "needs the module surfaces: modules.geometry of the aircraft"
    elif mission.flight_path is None:
        lacking = "needs a flight path: flight_path of the mission"
    models = tuple(
        Option(name, f"{name} – {model.label}", lacking if model.needs_path else "")
        for name, model in MODELS.items()
    )
    corrections = tuple(
        Option(name, _CORRECTION_LABELS[name], lacking if name == "loiter" else "")
        for name in CORRECTION_NAMES
    )
    fields: tuple[Field | Choice, ...] = (
        *_number_fields(aircraft, mission, at),
        Choice("model", "solar power model", solar.model, models),
        Choice("correction", "correction of its systematic error", solar.correction, corrections),
    )
    return {field.key: field for field in fields}


def _number_fields(aircraft: Aircraft, mission: Mission, at: tuple[float, int]) -> Iterator[Field]:
    measured = isinstance(aircraft.airframe, MeasuredAirframe)
    ends, days = (-90.0, 90.0), (1.0, 365.0)
    latitude, day = at[0], float(at[1])
    yield Field(
        LATITUDE, "place", "latitude", "°", latitude, *ends, ends, 0.1, about=_ABOUT_LATITUDE
    )
    yield Field(DAY, "place", "day of year", "", day, *days, days, 1.0, about=_ABOUT_DAY)
    payload_ends = {}  # what such an aircraft may carry
    with suppress(ImpossibleDesignError):
        design = design_of(aircraft, mission)
        payload_ends = {
            "mission.payload.mass_kg": _PAYLOAD_OF_MASS * float(design.total_mass_kg),
            "mission.payload.power_w": _PAYLOAD_OF_LOAD * float(design.nominal_load_w(mission)),
        }
    for group, keys in _GROUPS.items():
        for key, step in keys.items():
            value = parameter_value(aircraft, mission, key)
            if value is None:
                continue
            known = parameter(key)
            minimum, maximum = min(known.minimum, value), max(known.maximum, value)
            slider = (minimum, maximum)
            if group == "design":
                space = getattr(aircraft.design_space, variable_keys()[key])
                if isinstance(space, Range) and not measured:
                    minimum, maximum = min(minimum, space.minimum), max(maximum, space.maximum)
                low = _round(_SLIDER_FROM * value, math.floor)
                high = _round(_SLIDER_TO * value, math.ceil)
                slider = (max(low, minimum), min(high, maximum))
            elif key in payload_ends:
                high = _round(payload_ends[key], math.ceil)
                maximum = max(maximum, _PAYLOAD_BEYOND * high)  # of a large aircraft
                slider = (minimum, min(max(high, value), maximum))
            fixed = _MEASURED if measured and key.startswith("airframe.") else ""
            if key == WIND and mission.wind_statistics is not None:
                fixed = _OF_PERCENTILE.format(mission.wind_statistics.percentile)
            by_night = key == ALTITUDE and mission.climb is not None
            label = "altitude by night" if by_night else known.label
            unit, ends = unit_text(known.unit).replace("deg", "°"), (minimum, maximum)
            yield Field(key, group, label, unit, value, *ends, slider, step, fixed, known.about)


def _round(value: float, rounded: Any) -> float:
    """Return the number of two digits next to a positive one."""
    if value <= 0.0:
        return 0.0
    scale = 10.0 ** (math.floor(math.log10(value)) - 1)
    return significant(rounded(value / scale - 1e-9) * scale)
