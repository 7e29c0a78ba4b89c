"""What the steps of a day with climbs do, and the record of them."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from sizing.altitude.climb_chain import Place
from solar.types import FloatArray

# A half: NumPy takes half as long with it as with a number.
_HALF = np.array(0.5)


class Stored(NamedTuple):
    """Energy in the battery, and potential energy above the lowest level [Wh]; per element."""

    battery_wh: FloatArray
    potential_wh: FloatArray


class Power(NamedTuple):
    """Power of steps, and what is left over or lacking in them whatever is stored.

    Of sun and motor in level flight at both ends, ``(..., end, element)``, at the altitude of the
    middle [W]; surplus and deficit, that of the avionics alone, and what the propulsion could take
    besides level flight while there is a surplus [Wh]; ``sunlit_h`` is how long there is one. A
    deficit comes before the surplus of its step where ``early`` is 1, after it where that is 0.
    """

    solar_w: FloatArray
    motor_w: FloatArray
    surplus_wh: FloatArray
    deficit_wh: FloatArray
    of_avionics_wh: FloatArray
    room_wh: FloatArray
    sunlit_h: FloatArray
    early: FloatArray


def mean_of_ends(power_w: FloatArray) -> FloatArray:
    """Mean over steps of a power that is linear over each, from both ends."""
    return np.asarray((power_w[..., 0, :] + power_w[..., 1, :]) * _HALF)


class Drawn(NamedTuple):
    """What is stored after a deficit, and what was given [Wh]; ``glide_wh`` is electric, saved."""

    end: Stored
    drawn_wh: FloatArray
    glide_wh: FloatArray
    sunk_wh: FloatArray
    unserved_wh: FloatArray


class Moves(NamedTuple):
    """What a step does with what is stored; per element."""

    first: Drawn | None
    charged_wh: FloatArray
    left_over_wh: FloatArray
    climb_wh: FloatArray
    lifted_wh: FloatArray
    second: Drawn | None
    end: Stored


class Record(Protocol):
    """What is told of every step of a day that is flown."""

    def keep(self, number: int, moves: Moves, power: Power | None, place: Place | None) -> None:
        """What a step does; ``power`` where it is above the lowest altitude."""

    def discharge(
        self, steps: slice, stored: Stored, used_wh: FloatArray, eta: float | FloatArray
    ) -> None:
        """Steps on the battery alone; ``used_wh``: what they have taken of it together."""


class DayRun:
    """What a day has done, step by step; time is the first axis, elements the second.

    ``energy_wh`` and ``potential_wh`` are stored at the nodes of the steps. Energy that moves in a
    step [Wh]: ``charged``, ``drawn``, ``left_over`` of the surplus, of that ``climb``, ``glide``,
    which is electric energy that sinking has saved, ``unserved``, and potential energy ``lifted``
    and ``sunk``. ``thrust_w``: thrust power of level flight, where there is no constant
    ``efficiency`` [W].
    """

    def __init__(
        self,
        at_floor: Power,
        thrust_w: FloatArray,
        hours: FloatArray,
        efficiency: FloatArray | None,
    ) -> None:
        # Most steps are at the lowest altitude.
        self.power, self.thrust_w = Power(*(v.copy() for v in at_floor)), thrust_w.copy()
        self.hours, self.efficiency = hours, efficiency
        steps, elements = self.power.surplus_wh.shape
        self.energy_wh, self.potential_wh = np.zeros((2, steps + 1, elements))
        self.charged, self.drawn, self.left_over = np.zeros((3, steps, elements))
        self.climb, self.glide, self.unserved = np.zeros((3, steps, elements))
        self.lifted, self.sunk = np.zeros((2, steps, elements))

    def keep(self, number: int, moves: Moves, power: Power | None, place: Place | None) -> None:
        """Keep what a step does; ``power`` where it is above the lowest altitude."""
        self.charged[number], self.left_over[number] = moves.charged_wh, moves.left_over_wh
        self.climb[number], self.lifted[number] = moves.climb_wh, moves.lifted_wh
        for drawn in (moves.first, moves.second):
            if drawn is not None:
                self.drawn[number] += drawn.drawn_wh
                self.glide[number] += drawn.glide_wh
                self.sunk[number] += drawn.sunk_wh
                self.unserved[number] += drawn.unserved_wh
        self.energy_wh[number + 1], self.potential_wh[number + 1] = moves.end
        if power is not None:
            for row, values in zip(self.power, power, strict=True):
                row[number] = values
        if place is not None:
            self.thrust_w[number] = place.thrust_w

    def discharge(
        self, steps: slice, stored: Stored, used_wh: FloatArray, eta: float | FloatArray
    ) -> None:
        """Keep steps on the battery alone; ``used_wh``: what they have taken of it together."""
        energy_wh = np.maximum(stored.battery_wh - used_wh, 0.0)
        self.energy_wh[steps.start + 1 : steps.stop + 1] = energy_wh
        drawn_wh = -np.diff(np.concatenate([stored.battery_wh[np.newaxis], energy_wh]), axis=0)
        self.drawn[steps] = drawn_wh
        lacking_wh = self.power.deficit_wh[steps] - eta * drawn_wh
        # What rounding leaves of a deficit that is met is none.
        self.unserved[steps] = np.where(energy_wh <= 0.0, np.maximum(lacking_wh, 0.0), 0.0)

    @property
    def solar_wh(self) -> FloatArray:
        """Energy of the modules in every step [Wh]."""
        return mean_of_ends(self.power.solar_w) * self.hours

    @property
    def level_electric_wh(self) -> FloatArray:
        """Electric energy that level flight takes in every step [Wh]."""
        return mean_of_ends(self.power.motor_w) * self.hours

    @property
    def motor_wh(self) -> FloatArray:
        """Electric energy of the propulsion in every step [Wh]."""
        return self.level_electric_wh + self.climb - self.glide

    @property
    def level_thrust_wh(self) -> FloatArray:
        """Thrust power of level flight over every step [Wh]."""
        if self.efficiency is not None:
            return self.efficiency * self.level_electric_wh
        return self.thrust_w * self.hours

    @property
    def missing_h(self) -> FloatArray:
        """Hours without energy."""
        lacking = (self.hours - self.power.sunlit_h) * self.unserved
        return np.asarray((lacking / np.maximum(self.power.deficit_wh, 1e-300)).sum(axis=0))
