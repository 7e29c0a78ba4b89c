"""Planform of the wing, and size of the tail planes.

Positions are behind the leading edge of the wing root [m]. The formulas use arithmetic alone, for
floats, arrays and symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field, Strict, model_validator

from sizing.smooth import Value, smooth_maximum
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Real, Record, wrong_value

QUARTER = 0.25  # aerodynamic centre of a thin section over its chord
_ControlChord = Annotated[float, Strict(), Field(ge=0.05, le=1.0)]
_Deflection = Annotated[float, Strict(), Field(gt=0.0, le=45.0)]


def lift_slope(aspect_ratio: Value) -> Value:
    """Return the lift slope of a straight wing or tail plane of any aspect ratio [1/rad].

    ``2 pi AR/(2 + sqrt(4 + AR^2))``, Helmbold's equation: Raymer, D. P., Aircraft Design: A
    Conceptual Approach, eq. 12.6, without sweep at low Mach numbers.
    """
    return 2.0 * pi * aspect_ratio / (2.0 + (4.0 + aspect_ratio**2) ** 0.5)


class Wing(NamedTuple):
    """Wing with a straight quarter-chord line.

    ``aerodynamic_chord_m`` is the mean aerodynamic chord, ``(2/S) int c^2 dy``, the unit of static
    margins.
    """

    wingspan_m: Value
    aspect_ratio: Value
    root_chord_m: Value
    aerodynamic_chord_m: Value

    @property
    def mean_chord_m(self) -> Value:
        """Mean chord, area over span [m]."""
        return self.wingspan_m / self.aspect_ratio

    @property
    def area_m2(self) -> Value:
        """Wing area [m2]."""
        return self.wingspan_m * self.mean_chord_m

    @property
    def quarter_m(self) -> Value:
        """Position of the quarter-chord line and the aerodynamic centre [m]."""
        return QUARTER * self.root_chord_m

    def at_chord(self, fraction: float) -> Value:
        """Return the position of a fraction of the mean aerodynamic chord [m]."""
        return self.quarter_m + (fraction - QUARTER) * self.aerodynamic_chord_m


class Planform(Record):
    """Planform of two panels to a side: a rectangle inside, straight taper outside.

    ``inner_fraction`` is the rectangle's share of the half-span, ``taper_ratio`` the chord of the
    tip over the root's.
    """

    inner_fraction: Annotated[float, Strict(), Field(ge=0.0, lt=1.0)]
    taper_ratio: Fraction

    def wing(self, wingspan_m: Value, aspect_ratio: Value) -> Wing:
        """Return the wing of this planform with area ``span^2/aspect_ratio``."""
        outer, taper = 1.0 - self.inner_fraction, self.taper_ratio
        mean = self.inner_fraction + outer * (1.0 + taper) / 2.0
        square = self.inner_fraction + outer * (1.0 + taper + taper**2) / 3.0
        root_m = wingspan_m / aspect_ratio / mean
        return Wing(wingspan_m, aspect_ratio, root_m, root_m * (square / mean))


_RECTANGLE = Planform(inner_fraction=0.0, taper_ratio=1.0)


def wing_of(planform: Planform | None, wingspan_m: Value, aspect_ratio: Value) -> Wing:
    """Return the wing of a planform; a rectangle if there is none."""
    return (planform or _RECTANGLE).wing(wingspan_m, aspect_ratio)


class TailPlanes(NamedTuple):
    """Tail planes of an aircraft; areas include both halves and all fins.

    ``arm_m``, ``vertical_arm_m``: distance of the quarter chords of wing and horizontal tail, and
    of wing and fins. ``boom_m``: length of the booms, the larger distance. ``fin_height_m``,
    ``fin_chord_m``: size of a single fin.
    """

    arm_m: Value
    vertical_arm_m: Value
    boom_m: Value
    horizontal_m2: Value
    horizontal_span_m: Value
    horizontal_chord_m: Value
    vertical_m2: Value
    fin_height_m: Value
    fin_chord_m: Value


# Keys of the tail in place of others, of which one is needed.
_NEEDED = {
    "arm_chords": "arm_m",
    "horizontal_area_m2": "horizontal_volume",
    "vertical_area_m2": "vertical_volume",
}


class Tail(Record):
    """Tail planes by volume coefficients or areas; the fins may have another arm.

    ``V_h = S_h l/(S c)`` with the mean aerodynamic chord, ``V_v = S_v l/(S b)`` (Raymer, eq. 6.26
    and 6.27). With an arm in chords and volume coefficients the tail scales with the wing.
    """

    _in_place_of: ClassVar[Mapping[str, str]] = {**_NEEDED, "vertical_arm_chords": "vertical_arm_m"}

    arm_m: PositiveReal | None = None
    arm_chords: PositiveReal | None = None
    vertical_arm_m: PositiveReal | None = None
    vertical_arm_chords: PositiveReal | None = None
    horizontal_volume: PositiveReal | None = None
    horizontal_area_m2: PositiveReal | None = None
    vertical_volume: PositiveReal | None = None
    vertical_area_m2: PositiveReal | None = None
    horizontal_aspect_ratio: PositiveReal = 5.0
    vertical_aspect_ratio: PositiveReal = 2.0
    fins: Annotated[int, Strict(), Field(ge=1, le=2)] = 1
    horizontal_height_m: Real = 0.0
    thickness_ratio: NonNegativeReal = 0.08
    dynamic_pressure_ratio: Fraction = 0.9
    elevator_chord_fraction: _ControlChord = 0.3
    elevator_deflection_deg: _Deflection = 20.0
    rudder_chord_fraction: _ControlChord = 0.4
    rudder_deflection_deg: _Deflection = 25.0

    @model_validator(mode="after")
    def _check_sizes(self) -> Tail:
        for second, first in _NEEDED.items():
            if getattr(self, first) is None and getattr(self, second) is None:
                raise wrong_value(first, f"required key is missing (or {second}, above 0)")
        return self

    def planes(self, wing: Wing) -> TailPlanes:
        """Return the tail planes behind a wing."""
        arm_m = self.arm_m or wing.mean_chord_m * self.arm_chords
        vertical_m, boom_m = self.vertical_arm_m, arm_m
        if self.vertical_arm_chords is not None:
            vertical_m = wing.mean_chord_m * self.vertical_arm_chords
        if vertical_m is not None:
            boom_m = smooth_maximum(arm_m, vertical_m)
        fins_m = arm_m if vertical_m is None else vertical_m
        horizontal = self.horizontal_area_m2
        if horizontal is None:
            horizontal = self.horizontal_volume * (wing.area_m2 / arm_m) * wing.aerodynamic_chord_m
        vertical = self.vertical_area_m2
        if vertical is None:
            vertical = self.vertical_volume * (wing.area_m2 / fins_m) * wing.wingspan_m
        chord_m = (horizontal / self.horizontal_aspect_ratio) ** 0.5
        fin_m = (vertical / self.fins / self.vertical_aspect_ratio) ** 0.5
        return TailPlanes(
            arm_m=arm_m,
            vertical_arm_m=fins_m,
            boom_m=boom_m,
            horizontal_m2=horizontal,
            horizontal_span_m=self.horizontal_aspect_ratio * chord_m,
            horizontal_chord_m=chord_m,
            vertical_m2=vertical,
            fin_height_m=self.vertical_aspect_ratio * fin_m,
            fin_chord_m=fin_m,
        )

    def structure_keys(self, wing: Wing) -> dict[str, Value]:
        """Return boom length and tail volumes in mean chords, by the structure model's keys."""
        planes = self.planes(wing)
        volume = planes.boom_m / (wing.area_m2 * wing.mean_chord_m)
        return {
            "fuselage_chords": planes.boom_m / wing.mean_chord_m,
            "horizontal_tail_ratio": planes.horizontal_m2 * volume,
            "vertical_tail_ratio": planes.vertical_m2 * volume,
        }
