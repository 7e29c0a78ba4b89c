"""What may be fitted to a flight log: names, keys of the aircraft's file, and ranges."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.parameters import all_replaced, parameter_value
from solar.modules import MpptTable

ChannelName = Literal["solar", "load", "charge"]

# Points at which the shipped curve of the MPPT is written down where a fit changes it.
_MPPT_LOADS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 1.0)


@dataclass(frozen=True)
class FitParameter:
    """A number of the aircraft's file that a flight log may tell.

    ``name``: as the command line and results have it. ``key``: in the aircraft's file. ``channel``:
    measurement that it follows from. ``lowest``, ``highest``: ends of the search: limits of
    physics, or of what has been built. ``known``: half-width of what is taken as known before the
    flight, relative to the value; absolute where ``absolute``. An interval that is wider says
    nothing new: assumption.
    """

    name: str
    key: str
    label: str
    unit: str
    channel: ChannelName
    lowest: float
    highest: float
    known: float
    absolute: bool = False

    def value(self, aircraft: Aircraft) -> float:
        """Value that the aircraft's file has."""
        value = parameter_value(aircraft, None, self.key)
        if value is None:
            raise ValueError(f"{aircraft.name} has no {self.key}")
        return value

    def widest(self, value: float) -> float:
        """Half-width beyond which an interval says nothing."""
        return self.known if self.absolute else self.known * abs(value)

    def applied(self, aircraft: Aircraft, value: float) -> Aircraft:
        """Aircraft with another value, not validated."""
        changes: dict[str, Any] = {self.key: value}
        if self.name == MPPT:  # the Full Model takes it from a curve, which moves along
            factor = value / aircraft.modules.mppt_efficiency
            changes["modules.mppt"] = scaled_mppt(aircraft, factor)
        return all_replaced(aircraft, changes)


MPPT = "mppt_efficiency"
_DRAG = "airframe.aerodynamics"
_LEVEL = "airframe.level_flight.electric_power_w"
_ENERGY = "battery.specific_energy_wh_per_kg"
_COEFFICIENT = "modules.temperature_coefficient_per_k"
_IN, _OUT = "battery.charge_efficiency", "battery.discharge_efficiency"
_P = FitParameter
# fmt: off
_ALL = (
    _P("module_efficiency", "modules.efficiency_stc", "module efficiency", "",
       "solar", 0.02, 0.868, 0.3),
    _P(MPPT, "modules.mppt_efficiency", "MPPT efficiency", "", "solar", 0.3, 1.0, 0.1),
    _P("temperature_rise", "modules.temperature_rise_k", "modules above the air", "K",
       "solar", 0.0, 80.0, 10.0, absolute=True),
    _P("temperature_coefficient", _COEFFICIENT, "temperature coefficient", "1/K",
       "solar", 0.0, 0.02, 0.003, absolute=True),
    _P("level_power", _LEVEL, "power of level flight", "W", "load", 1e-3, 1e6, 0.5),
    _P("profile_drag", f"{_DRAG}.profile_drag_coefficient", "profile drag coefficient", "",
       "load", 1e-4, 1.0, 1.0),
    _P("drag_calibration", f"{_DRAG}.calibration", "calibration of the drag", "",
       "load", 0.05, 20.0, 0.5),
    _P("avionics_power", "power.avionics_w", "avionics power", "W", "load", 0.0, 1e5, 1.0),
    _P("specific_energy", _ENERGY, "usable energy of the battery", "Wh/kg",
       "charge", 1.0, 6443.0, 0.5),
    _P("charge_efficiency", _IN, "charge efficiency", "", "charge", 0.3, 1.0, 0.2),
    _P("discharge_efficiency", _OUT, "discharge efficiency", "", "charge", 0.3, 1.0, 0.2),
)
# fmt: on
PARAMETERS = MappingProxyType({one.name: one for one in _ALL})


def default_names(aircraft: Aircraft) -> tuple[str, ...]:
    """What is fitted unless something else is asked for, of an aircraft of this kind."""
    return ("module_efficiency", "temperature_rise", power_name(aircraft), "specific_energy")


def power_name(aircraft: Aircraft) -> str:
    """Parameter that sets the power of level flight of an aircraft of this kind."""
    airframe = aircraft.airframe
    if isinstance(airframe, MeasuredAirframe):
        return "level_power"
    return "profile_drag" if airframe.aerodynamics.model == "parabolic" else "drag_calibration"


def chosen(names: tuple[str, ...], aircraft: Aircraft) -> tuple[FitParameter, ...]:
    """Parameters by their names, in their order and each once."""
    parameters = []
    for name in dict.fromkeys(names or default_names(aircraft)):
        if name not in PARAMETERS:
            raise ValueError(f"{name!r} cannot be fitted (allowed: {', '.join(PARAMETERS)})")
        one = PARAMETERS[name]
        if parameter_value(aircraft, None, one.key) is None:
            other = f": fit {power_name(aircraft)}" if one.channel == "load" else ""
            raise ValueError(f"{name} cannot be fitted: {aircraft.name} has no {one.key}{other}")
        if one.key in (_IN, _OUT) and aircraft.battery.resistance is not None:
            message = f"{aircraft.name} has battery.resistance, which replaces {one.key}"
            raise ValueError(f"{one.name} cannot be fitted: {message}")
        parameters.append(one)
    return tuple(parameters)


def scaled_mppt(aircraft: Aircraft, factor: float) -> MpptTable:
    """Curve of the MPPT that the Full Model reads, times a factor; not validated."""
    modules = aircraft.modules
    loads = _MPPT_LOADS if modules.mppt is None else modules.mppt.relative_load
    efficiency = modules.mppt_efficiency_at(loads)
    return MpptTable.model_construct(
        relative_load=tuple(loads),
        mppt_efficiency=tuple(float(value) for value in factor * efficiency),
    )


def replaced_values(
    aircraft: Aircraft, parameters: tuple[FitParameter, ...], values: tuple[float, ...]
) -> Aircraft:
    """Aircraft with other values of some parameters, each in its unit; not validated."""
    for one, value in zip(parameters, values, strict=True):
        aircraft = one.applied(aircraft, float(value))
    return aircraft
