"""A climbing AS-2 by explicit Euler steps on altitude and energy; nothing of the simulator.

The density is that of another atmosphere (ambiance), the sun alone is the project's own.
"""

import ambiance
import numpy as np

from solar.horizontal_models import horizontal_specific_power
from solar.modules import SolarCell

FLOOR_M = 536.0
ETA = 0.626  # .97 x .82 x .96 x .82, as the file rounds it
FULL_WH = 2.918 * 251.0
CHARGE, DISCHARGE = 0.95, 0.97
AVIONICS_W, MOST_W = 6.0, 180.0


class PlainClimb:
    """Steps through a day at 47.6 N; states are arrays, one element per flight."""

    def __init__(self, day, ceiling_m, *, surplus=False, limit=None, step_s=10.0):
        self.ceiling_m, self.surplus, self.limit = ceiling_m, surplus, limit
        self.step_h = step_s / 3600.0
        self.heights = np.linspace(FLOOR_M, max(ceiling_m, FLOOR_M + 1.0), 60)
        air = ambiance.Atmosphere(self.heights)
        minutes = np.linspace(0.0, 24.0, 24 * 60 + 1)
        # The light is linear between the nodes of the day there, 5 min; sampled alike here.
        coarse = minutes[::5]
        self.light = 1.35 * np.stack(
            [
                np.interp(
                    minutes,
                    coarse,
                    horizontal_specific_power(
                        *(47.6, day + 0.5, coarse),
                        cell=SolarCell(),
                        module_temperature_c=float(t) - 273.15,
                        altitude_m=float(h),
                    ),
                )
                for h, t in zip(self.heights, air.temperature, strict=True)
            ]
        )
        self.level_w = 35.8 * (air.density / 1.10) ** -0.5
        speed = 8.4 * (air.density / 1.10) ** -0.5
        weight = 6.92 * 9.80665
        by_speed = np.gradient(speed**2 / 2.0, self.heights) / 9.80665
        self.wh_per_m = weight * (1.0 + by_speed) / 3600.0

    def step(self, hour, energy, altitude):
        """Energy and altitude after a step from some hours on, and the net power of level flight.

        An energy below zero is what lacks.
        """
        middle = (hour + self.step_h / 2.0) % 24.0
        spacing = self.heights[1] - self.heights[0]
        i = np.minimum(((altitude - FLOOR_M) / spacing).astype(int), len(self.heights) - 2)
        f = (altitude - self.heights[i]) / spacing
        j = np.minimum((middle * 60.0).astype(int), 24 * 60 - 1)
        g = middle * 60.0 - j
        sun = (1 - f) * ((1 - g) * self.light[i, j] + g * self.light[i, j + 1]) + f * (
            (1 - g) * self.light[i + 1, j] + g * self.light[i + 1, j + 1]
        )
        motor = (1 - f) * self.level_w[i] + f * self.level_w[i + 1]
        wh_per_m = (1 - f) * self.wh_per_m[i] + f * self.wh_per_m[i + 1]
        net, dt = sun - motor - AVIONICS_W, self.step_h
        # By surplus: the charger first, then the climb.
        stored = np.minimum(CHARGE * net * dt, FULL_WH - energy)
        if self.limit is not None:
            taper = self.limit.taper_start
            way = np.maximum(energy / FULL_WH - taper, 0.0) / (1.0 - taper)
            rate = self.limit.c_rate_per_h * self.limit.relative_rate_at_full**way
            stored = np.minimum(stored, FULL_WH * rate * dt)
        left_w = net - stored / CHARGE / dt
        may_climb = self.surplus | (energy + stored >= FULL_WH * (1 - 1e-12))
        climb_w = np.where(may_climb, np.clip(left_w, 0.0, MOST_W - motor), 0.0)
        higher = np.minimum(altitude + ETA * climb_w * dt / wh_per_m, self.ceiling_m)
        # By deficit: the height first, the battery for the avionics alone.
        driven = np.maximum(sun - AVIONICS_W, 0.0)
        lower = np.maximum(altitude - ETA * (motor - driven) * dt / wh_per_m, FLOOR_M)
        aloft = altitude > FLOOR_M
        drawn_w = np.where(aloft, np.maximum(AVIONICS_W - sun, 0.0), -net)
        up = net >= 0.0
        energy = np.where(up, energy + stored, energy - drawn_w * dt / DISCHARGE)
        return energy, np.where(up, higher, lower), net

    def flight_h(self, launch_h, most_days=12.0):
        """Flight times from launches at the floor with a full battery [h]; NaN beyond some days."""
        energy, altitude = np.full(len(launch_h), FULL_WH), np.full(len(launch_h), FLOOR_M)
        flown = np.full(len(launch_h), np.nan)
        for number in range(int(most_days * 24.0 / self.step_h)):
            before, elapsed = energy, number * self.step_h
            energy, altitude, _ = self.step(launch_h + elapsed, before, altitude)
            ends = (energy < 0.0) & np.isnan(flown)
            part = before / np.where(ends, before - energy, 1.0)
            flown = np.where(ends, elapsed + part * self.step_h, flown)
            if not np.isnan(flown).any():
                break
        return flown
