"""Places of an aircraft's masses: positions of its parts, or a list of weighed masses.

Positions are behind the leading edge of the wing root: in mean chords, which scale with the wing,
or in metres for weighed masses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field, Strict, model_validator

from sizing.smooth import Value
from solar.schema import Name, PositiveReal, Real, Record, wrong_value

_Margin = Annotated[float, Strict(), Field(gt=-1.0, lt=2.0)]
# Centroids of the wing's parts over its chord: the spar where the section is thickest; skin of both
# sides; area of a four-digit section (Abbott and von Doenhoff, Theory of Wing Sections, section
# 6.4: 0.42); sheeted nose and a light trailing edge (assumption).
WING_PARTS = {"spar_caps": 0.3, "spar_web": 0.3, "covering": 0.5, "ribs": 0.42, "edges": 0.2}
SPAR = 0.3
# Mass of a tail plane lies behind its quarter chord (assumption: at 0.4 of its chord).
TAIL_MASS = 0.15


class Item(NamedTuple):
    """Mass and its place behind the leading edge of the wing root [m]."""

    name: str
    mass_kg: Value
    x_m: Value


def centre_of_gravity(items: Sequence[Item]) -> Value:
    """Return the place of the centre of gravity, ``sum(m x)/sum(m)`` [m]."""
    mass = sum((item.mass_kg for item in items[1:]), items[0].mass_kg)
    return sum((i.mass_kg * i.x_m for i in items[1:]), items[0].mass_kg * items[0].x_m) / mass


class WeighedMass(Record):
    """Weighed mass, with its place behind the leading edge of the wing root [m]."""

    name: Name
    mass_kg: PositiveReal
    x_m: Real


class Positions(Record):
    """Places of parts that the mass build-up does not locate, in mean chords; all assumptions.

    The propeller is a tractor ahead of the wing, the pod lies at its leading edge. ``battery`` is
    the part of the battery outside the wing.
    """

    propulsion: Real = -0.6
    battery: Real = 0.0
    modules: Real = 0.5
    mppt: Real = 0.2
    avionics: Real = 0.2
    payload: Real = 0.3
    other: Real = 0.2
    pod: Real = 0.1


class Balance(Record):
    """Key ``airframe.balance``: masses with their places, and the required static margin.

    ``weighed``: all masses of the aircraft, in place of the build-up. ``static_margin``: neutral
    point behind the centre of gravity, over the mean aerodynamic chord, for the drag of trim.
    """

    explained_keys: ClassVar[Mapping[str, str]] = dict.fromkeys(
        (
            "held_by",
            "moved",
            "foremost_chords",
            "rearmost_chords",
            "minimum_horizontal_volume",
            "maximum_horizontal_volume",
        ),
        "nothing is moved or sized for a static margin: give positions_chords and airframe.tail; "
        "the tail that would have the margin is reported",
    )

    positions_chords: Positions = Positions()
    weighed: tuple[WeighedMass, ...] = ()
    static_margin: _Margin | None = None
    pitching_moment_coefficient: Real = -0.1

    @model_validator(mode="after")
    def _check_choice(self) -> Balance:
        if self.weighed and self.static_margin is not None:
            text = "follows from weighed; give one of them"
            raise wrong_value("static_margin", text, got=self.static_margin)
        return self
