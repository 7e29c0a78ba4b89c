"""What an offline page computes from: light over place and season, and designs, as tables.

Solar power per area of module depends on place, date and solar power model, not on the design;
mass and power of level flight depend on the design, not on place and date. Two tables hold both;
the page interpolates in them and marches the battery itself. Light is tabled between sunrise and
sunset, which the page computes exactly: then it is smooth where days become long or short.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import Design, variables_of
from sizing.mass_budget import closed_design, measured_design
from sizing.sunlight import SolarModel, solar_day
from solar.sun import declination
from solar.types import FloatArray

DAY_STEP = 7
_LATITUDES_DEG = np.linspace(-90.0, 90.0, 73)
_DAYS = np.arange(1, 366, DAY_STEP)
# Models that follow the flight path take milliseconds for each place and date.
_LATITUDES_ON_PATH_DEG = np.linspace(-90.0, 90.0, 19)
_DAYS_ON_PATH = np.arange(1, 366, 2 * DAY_STEP)
_OF_DAYLIGHT = np.linspace(0.0, 1.0, 97)
_LARGEST = 32767  # of an integer of 16 bits
_IMPOSSIBLE = -32768

# Key of the explorer's field -> name of the design variable, and number of its values in the table.
AXES: dict[str, tuple[str, int]] = {
    "airframe.wingspan_m": ("wingspan_m", 25),
    "battery.mass_kg": ("battery_mass_kg", 25),
    "modules.area_m2": ("module_area_m2", 9),
    "mission.payload.mass_kg": ("payload_mass_kg", 5),
}


@dataclass(frozen=True)
class Axis:
    """Values of a design variable in the table.

    ``key``: of the explorer's field. ``values``: in rising order, in equal ratios where the least
    is above zero.
    """

    key: str
    values: FloatArray

    @classmethod
    def between(cls, key: str, low: float, high: float, start: float) -> Axis:
        """Values of a slider's range, the one at the start among them.

        ``low``, ``high``: ends of the range; the same for a single value. ``start``: value in
        between that the table is to have exactly.
        """
        count = AXES[key][1] if high > low else 1
        spaced = np.geomspace if low > 0.0 else np.linspace
        return cls(key, np.union1d(spaced(low, high, count), [low, start, high]))

    def to_dict(self) -> dict[str, Any]:
        """For the page."""
        return {"key": self.key, "values": [float(f"{value:.9g}") for value in self.values]}


def quantised(values: FloatArray) -> dict[str, Any]:
    """Table as integers of 16 bits, with what turns them back into numbers.

    ``values``: of any shape; what is not finite has its own integer. Returns ``shape``; ``offset``
    and ``scale``: a number is offset + scale times its integer; ``base64``: the integers, least
    byte first; ``impossible``: the integer of what is none.
    """
    finite = np.isfinite(values)
    some = values[finite] if finite.any() else np.zeros(1)
    low, high = float(some.min()), float(some.max())
    offset, scale = (low + high) / 2.0, max((high - low) / (2.0 * _LARGEST), 1e-300)
    steps = np.rint((np.where(finite, values, offset) - offset) / scale)
    integers = np.where(finite, steps, _IMPOSSIBLE).astype("<i2")
    return {
        "shape": list(values.shape),
        "offset": offset,
        "scale": scale,
        "impossible": _IMPOSSIBLE,
        "base64": base64.b64encode(integers.tobytes()).decode("ascii"),
    }


def light_table(aircraft: Aircraft, mission: Mission, solar: SolarModel) -> dict[str, Any]:
    """Solar power per module area over latitude, day of year and share of the daylight.

    ``aircraft``, ``mission``: modules; air, wind and flight path. The mission's own place and date
    play no part. Returns ``latitudes_deg``, ``days`` and the table ``power_w_per_m2``, whose last
    axis runs evenly from sunrise to sunset, or to noon where afternoons are ``mirrored`` mornings;
    ``declinations_rad`` of all days of the year, from the first.
    """
    on_path = solar.needs_path
    latitudes = _LATITUDES_ON_PATH_DEG if on_path else _LATITUDES_DEG
    days = _DAYS_ON_PATH if on_path else _DAYS
    latitude, day = np.repeat(latitudes, len(days)), np.tile(days, len(latitudes))
    sunlit = solar_day(aircraft, mission, solar, scenarios=Scenarios(latitude, day))
    rise, fall = np.asarray(sunlit.sunrise_h), np.asarray(sunlit.sunset_h)
    power = np.zeros((len(latitude), len(_OF_DAYLIGHT)))
    for i in np.flatnonzero(fall > rise):
        hours = rise[i] + _OF_DAYLIGHT * (fall[i] - rise[i])
        power[i] = np.interp(hours, sunlit.time_h, sunlit.specific_power_w_per_m2[i])
    mirrored = bool(np.allclose(power, power[:, ::-1], rtol=0.0, atol=1e-6 * power.max()))
    if mirrored:
        power = power[:, : len(_OF_DAYLIGHT) // 2 + 1]
    year = Scenarios(np.zeros(365), np.arange(1, 366))
    return {
        "latitudes_deg": latitudes.tolist(),
        "days": days.tolist(),
        "mirrored": mirrored,
        "power_w_per_m2": quantised(power.reshape((len(latitudes), len(days), -1))),
        "declinations_rad": [float(f"{d:.7g}") for d in declination(year.noon_day)],
    }


def design_table(aircraft: Aircraft, mission: Mission, axes: Iterable[Axis]) -> dict[str, Any]:
    """Mass, power of level flight and airspeed over the design variables.

    ``axes``: variables that change; others stay as the files give them. Returns ``axes`` and the
    tables of logarithms ``log_mass_kg``, ``log_power_w`` and, where airspeed is known,
    ``log_airspeed_m_per_s``, with an axis for each; an aircraft that cannot carry itself is
    ``impossible`` there.
    """
    axes = list(axes)
    design = _designs(aircraft, mission, axes)
    tables = {
        "log_mass_kg": design.total_mass_kg,
        "log_power_w": design.propulsion_power_w,
        "log_airspeed_m_per_s": design.airspeed_m_per_s,
    }
    return {
        "axes": [axis.to_dict() for axis in axes],
        **{name: quantised(np.log(t)) for name, t in tables.items() if t is not None},
    }


def mass_table(aircraft: Aircraft, mission: Mission, axes: Iterable[Axis]) -> dict[str, Any]:
    """Parts of the total mass but battery and payload, which the page's settings give.

    ``axes``: as for :func:`design_table`, of which every second value is taken. Returns ``axes``,
    the names of all ``parts``, and by part the table of its share in the mass of these parts.
    Shares are interpolated linearly, so that they add up to one between the values as well.
    """
    axes = [replace(axis, values=np.union1d(axis.values[::2], axis.values[-1])) for axis in axes]
    parts = _designs(aircraft, mission, axes).masses._asdict()
    shape = tuple(len(axis.values) for axis in axes)
    of_page = ("battery", "payload")
    kept = {name: np.broadcast_to(kg, shape) for name, kg in parts.items() if name not in of_page}
    whole = sum(kept.values())
    return {
        "axes": [axis.to_dict() for axis in axes],
        "parts": list(parts),
        "shares": {name: quantised(mass / whole) for name, mass in kept.items()},
    }


def _designs(aircraft: Aircraft, mission: Mission, axes: list[Axis]) -> Design:
    """Design at every combination of the axes' values."""
    grids = np.meshgrid(*(axis.values for axis in axes), indexing="ij")
    chosen = {AXES[axis.key][0]: grid for axis, grid in zip(axes, grids, strict=True)}
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return _measured(aircraft, mission, chosen)
    return closed_design(aircraft, mission, variables_of(aircraft)._replace(**chosen))


def _measured(aircraft: Aircraft, mission: Mission, chosen: dict[str, FloatArray]) -> Design:
    """Designs of a measured airframe with other parts: masses, power and airspeed of each."""
    shape = next(iter(chosen.values())).shape
    designs = []
    for place in np.ndindex(shape):
        value = {name: float(grid[place]) for name, grid in chosen.items()}
        battery = aircraft.battery.model_copy(update={"mass_kg": value["battery_mass_kg"]})
        modules = aircraft.modules.model_copy(update={"area_m2": value["module_area_m2"]})
        payload = mission.payload.model_copy(update={"mass_kg": value["payload_mass_kg"]})
        designs.append(
            measured_design(
                aircraft.model_copy(update={"battery": battery, "modules": modules}),
                mission.model_copy(update={"payload": payload}),
            )
        )

    def grid(values: Iterable[Any]) -> FloatArray:
        return np.reshape(np.array([float(v) for v in values]), shape)

    first = designs[0]
    masses = (grid(kg) for kg in zip(*(design.masses for design in designs), strict=True))
    speeds = None
    if first.airspeed_m_per_s is not None:
        speeds = grid(design.airspeed_m_per_s for design in designs)
    return first._replace(
        masses=type(first.masses)(*masses),
        total_mass_kg=grid(design.total_mass_kg for design in designs),
        propulsion_power_w=grid(design.propulsion_power_w for design in designs),
        airspeed_m_per_s=speeds,
    )
