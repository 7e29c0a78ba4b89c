"""Days of a weather record: where they begin, and what their air is to a propulsion."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.air import ZERO_CELSIUS_K, air_at
from missions.mission import Mission
from missions.weather.light import RecordedLight
from missions.weather.record import SECONDS_PER_HOUR, day_of_year
from sizing.aircraft import Aircraft
from sizing.day.load import Flight, flight_of, part_load_of, part_load_over
from sizing.design import Design
from sizing.held_station import flight_against_wind
from sizing.mass_budget import ImpossibleDesignError
from sizing.propulsion.part_load import PartLoad, load_range
from solar.sun import HOURS_PER_DAY
from solar.types import FloatArray, IntArray

# A record that begins this near to midnight begins a day.
_NEAR_MIDNIGHT_H = 3.0


@dataclass(frozen=True)
class DayAxis:
    """Days of a record, from one local solar midnight to the next, and their nodes.

    ``nodes``: places in the record; a day's last node is the next day's first. ``time_h``: hours
    since the day's first node [h]. ``midnight_h``: solar time of each day's first node, about 0
    [h]. ``date``: date of each day in the calendar of the place. ``day_of_year``: that of the date,
    1 to 365; 29 February counts as 28 February. ``time_s``: universal time of each day's first node
    [s since 1970-01-01].
    """

    nodes: IntArray
    time_h: FloatArray
    midnight_h: FloatArray
    date: NDArray[np.datetime64]
    day_of_year: IntArray
    time_s: FloatArray

    def __len__(self) -> int:
        return len(self.nodes)

    @property
    def year(self) -> IntArray:
        """Calendar year of each day."""
        return self.date.astype("datetime64[Y]").astype(int) + 1970

    @property
    def month(self) -> IntArray:
        """Month of each day, 1 to 12."""
        return self.date.astype("datetime64[M]").astype(int) % 12 + 1

    @classmethod
    def of(cls, light: RecordedLight) -> DayAxis:
        """Cut a record into days; hours before the first and after the last are left out."""
        per_day = round(HOURS_PER_DAY / light.step_h)
        begin_h = float(light.time_solar_h[0])
        to_midnight_h = (HOURS_PER_DAY - begin_h) % HOURS_PER_DAY
        near = min(begin_h, to_midnight_h) <= _NEAR_MIDNIGHT_H
        skip = 0 if near else round(to_midnight_h / light.step_h)
        count = (len(light.time_s) - skip) // per_day
        if count < 1:
            raise ValueError("is shorter than a day from one solar midnight to the next")
        first = skip + per_day * np.arange(count)
        nodes = np.minimum(first[:, np.newaxis] + np.arange(per_day + 1), len(light.time_s) - 1)
        clock_h = light.time_solar_h[first]
        midnight_h = np.where(clock_h > 12.0, clock_h - HOURS_PER_DAY, clock_h)
        # Dates are those of the place at its noon, not of Greenwich.
        noon_h = HOURS_PER_DAY / 2.0 - midnight_h + light.site.calendar_offset_h
        date = (light.time_s[first] + SECONDS_PER_HOUR * noon_h).astype("datetime64[s]")
        date = date.astype("datetime64[D]")
        return cls(
            nodes=nodes,
            time_h=np.asarray(np.arange(per_day + 1) * light.step_h, float),
            midnight_h=midnight_h,
            date=date,
            day_of_year=day_of_year(date.astype("datetime64[s]").astype(float)).astype(int),
            time_s=light.time_s[first],
        )


@dataclass(frozen=True)
class LoadInAir:
    """Electric power of a design in air that changes its temperature, relative to its own.

    ``level_w``: propulsion power of level flight in the mission's air [W], of every day where each
    has an airspeed of its own. ``part_load``: power over it at some temperatures,
    ``temperatures_k``, between which a parabola passes.
    """

    level_w: FloatArray
    part_load: PartLoad
    temperatures_k: FloatArray

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        design: Design,
        air_c: ArrayLike,
        wind_m_per_s: FloatArray | None = None,
    ) -> LoadInAir | None:
        """Power between the ends of temperatures [C]; None for constant efficiencies.

        At the pressure of an altitude airspeed and drag times airspeed go with the square root of
        the absolute temperature. ``wind_m_per_s``: of each day, where the mission holds its place;
        power is then over that of the day's airspeed. Raises :class:`ImpossibleDesignError` where
        the propeller's data end before the greatest load of level flight; a day whose wind is too
        strong has no power instead.
        """
        if aircraft.propulsion_by_parts is None:
            return None
        if wind_m_per_s is None:
            part_load_of(aircraft, mission, design)  # which says what its own air is too much for
        own, flight = flight_of(aircraft, mission, design)
        level_w: FloatArray = np.asarray(design.propulsion_power_w)
        day: IntArray | None = None
        if wind_m_per_s is not None:
            # Days of equal wind, and of less than the airspeed, are one flight.
            each = np.maximum(wind_m_per_s, np.asarray(design.airspeed_m_per_s, float))
            some, day = np.unique(each, return_inverse=True)
            level_w, thrust_w, speed = flight_against_wind(aircraft, mission, design, some)
            flight = Flight.where(np.isfinite(level_w), thrust_w, speed, flight.air)
        least_c, most_c = float(np.min(air_c)), float(np.max(air_c))
        warm_k = ZERO_CELSIUS_K + np.linspace(least_c, most_c, 3 if most_c > least_c else 1)
        # Temperatures first, then the days.
        of_each = warm_k.reshape(-1, *(1,) * level_w.ndim)
        faster = np.sqrt(of_each / flight.air.temperature_k)
        there = Flight(
            np.asarray(flight.thrust_w * faster),
            flight.airspeed_m_per_s * faster,
            air_at(of_each, flight.air.pressure_pa),
        )
        turbulence = mission.turbulence
        loads = load_range(turbulence.all_day, turbulence.thermal)
        wide = np.broadcast_to(level_w, there.thrust_w.shape)
        part = part_load_over(own, there, wide, loads, aircraft.battery.nominal_voltage_v)
        if wind_m_per_s is None and np.any(part.beyond):
            raise ImpossibleDesignError(
                f"the propulsion of {aircraft.name} cannot do {float(loads[1]):.3g} times the "
                f"power of level flight in air of {least_c:.0f} to {most_c:.0f} C"
            )
        if day is None:
            return cls(level_w, part, warm_k)
        part = replace(part, coefficients=part.coefficients[..., day])
        return cls(level_w[day], part, warm_k)

    def at(self, load: FloatArray, air_c: FloatArray) -> FloatArray:
        """Power over that of level flight in the mission's air [-]; arguments broadcast."""
        wide = np.broadcast_arrays(load, air_c)
        axes = wide[0].ndim - (self.part_load.coefficients.ndim - 2)  # less that of the days
        powers = self.part_load.spread(axes).at(wide[0])
        known_k, warm_k = self.temperatures_k, wide[1] + ZERO_CELSIUS_K
        total = np.zeros(wide[0].shape)
        for k, one in enumerate(powers):
            apart = [(warm_k - other) / (known_k[k] - other) for other in np.delete(known_k, k)]
            total += math.prod(apart, start=one)
        return total
