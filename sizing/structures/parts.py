"""Parts of a rib wing, and what they are sized from."""

from __future__ import annotations

from functools import reduce
from typing import NamedTuple

from sizing.smooth import Value, smooth_maximum


class StructureParts(NamedTuple):
    """Masses of the structure's parts [kg], calibration included; they add up to the structure."""

    spar_caps: Value
    spar_web: Value
    covering: Value
    ribs: Value
    edges: Value
    tails: Value
    boom: Value
    pod: Value
    joints: Value

    @property
    def total_kg(self) -> Value:
        """Mass of the structure [kg]."""
        return sum(self[1:], self[0])


class LoadFactors(NamedTuple):
    """Limit load factors [-], all counted positive: pull-up or up-gust, and their opposites."""

    up: Value
    down: Value


class Wing(NamedTuple):
    """What the parts are sized from.

    ``sheet_m`` is at its gauge; ``nose_sheet_m`` weighs as much as the stiffened nose.
    """

    wingspan_m: Value
    chord_m: Value
    wing_area_m2: Value
    depth_m: Value
    equivalent_airspeed_m_per_s: Value
    total_mass_kg: Value
    relief_kg: Value
    pod_battery_kg: Value
    factors: LoadFactors
    sheet_m: Value
    nose_sheet_m: Value


class CapForces(NamedTuple):
    """Ultimate cap forces at a station [N], by load case.

    ``up`` and ``down`` are those of flight at the limit load factors, bending the wing up and down,
    ``landing`` bends it down; ``level`` is that of level flight, without the safety factor.
    """

    up: Value
    down: Value
    landing: Value
    level: Value

    @property
    def downwards(self) -> Value:
        """Largest force that bends the wing down: flight or landing."""
        return smooth_maximum(self.down, self.landing)


def largest(needs: dict[str, Value]) -> Value:
    """Smooth maximum of what several criteria ask for, in their order."""
    return reduce(smooth_maximum, needs.values())
