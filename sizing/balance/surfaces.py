"""Planform of the wing and size of the tail planes; static stability and trim of both.

Positions are behind the leading edge of the wing root [m]. Handbook formulas: neutral point, tail
lift, control authority. Arithmetic alone where an optimiser passes symbols. Sources at each
function; docs/balance.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import acos, pi, sin
from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field, Strict

from sizing.smooth import Value, smooth_maximum
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Real, Record

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


class Tail(Record):
    """Tail planes by volume coefficients or areas; the fins may have another arm.

    ``V_h = S_h l/(S c)`` with the mean aerodynamic chord, ``V_v = S_v l/(S b)`` (Raymer, eq. 6.26
    and 6.27). With an arm in chords and volume coefficients the tail scales with the wing.
    """

    _in_place_of: ClassVar[Mapping[str, str]] = {"vertical_arm_chords": "vertical_arm_m"}
    _either: ClassVar[Mapping[str, str]] = {
        "arm_chords": "arm_m",
        "horizontal_area_m2": "horizontal_volume",
        "vertical_area_m2": "vertical_volume",
    }

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


# ---- Static stability and trim

# Spacing of the rolled-up tip vortices of an elliptic lift over the span (Phillips, section 4.5).
_VORTEX_SPACING = pi / 4.0
# Share of a hinged flap's theoretical effect at an unsealed hinge (Phillips, section 1.7).
_HINGE = 0.8
# Effective over geometric aspect ratio of a fin at tail plane and body (Raymer, section 16.4.5).
_FIN_END_PLATE = 1.55
# (1 + d sigma/d beta) eta at the fins, of an unswept wing at mid height (Raymer, eq. 16.48):
# 0.724 + 3.06/2 S_v/S + 0.009 AR.
_SIDEWASH, _SIDEWASH_AREA, _SIDEWASH_RATIO = 0.724, 3.06 / 2.0, 0.009


def downwash_slope(wing: Wing, aft_m: Value, height_m: float) -> Value:
    """Return the change of downwash angle at the tail with the wing's angle of attack [-].

    ``d eps/d alpha = kappa_p/kappa_b a/AR`` of a bound vortex with two tip vortices, rolled up, of
    a wing with elliptic lift: Phillips, W. F., Mechanics of Flight, section 4.5.

    ``aft_m``, ``height_m``: position of the tail's quarter chord from the wing's.
    """
    half_m, spacing = wing.wingspan_m / 2.0, _VORTEX_SPACING
    x2, y2 = (aft_m / half_m) ** 2, (height_m / half_m) ** 2
    away = x2 + y2
    lattice = (away + spacing**2) ** 0.5
    bound = x2**0.5 * (x2 + 2.0 * y2 + spacing**2) / (away * lattice)
    position = 2.0 * spacing**2 / (pi**2 * (y2 + spacing**2)) * (1.0 + bound)
    return position / spacing * lift_slope(wing.aspect_ratio) / wing.aspect_ratio


class NeutralPoint(NamedTuple):
    """Neutral point with fixed controls.

    ``slope``: lift slope of the aircraft on the wing area [1/rad]. ``tail_slope``: lift slope of
    the tail plane on its own area [1/rad]. ``downwash``: ``d eps/d alpha`` at the tail [-].
    """

    x_m: Value
    slope: Value
    tail_slope: Value
    downwash: Value


def neutral_point(wing: Wing, tail: Tail, planes: TailPlanes, body_m3: float) -> NeutralPoint:
    """Return the stick-fixed neutral point.

    ``a = a_w (1 + eta S_h/S a_t/a_w (1 - d eps/d alpha))``,
    ``h_n = h_w + V_h eta a_t/a (1 - d eps/d alpha) - C_M,body/a`` (Etkin, B., and Reid, L. D.,
    Dynamics of Flight, 3rd ed., eq. 2.3,18 to 2.3,24). A slender body adds the moment slope
    ``2 volume/(S c)``, of all apparent mass across and none along (Munk, NACA TR 184, 1924).

    ``body_m3`` is the volume of the pods.
    """
    tail_slope = lift_slope(tail.horizontal_aspect_ratio)
    downwash = downwash_slope(wing, planes.arm_m, tail.horizontal_height_m)
    area = planes.horizontal_m2 / wing.area_m2
    tail_slope_on_wing = tail.dynamic_pressure_ratio * area * tail_slope * (1.0 - downwash)
    slope = lift_slope(wing.aspect_ratio) + tail_slope_on_wing
    body_m = 2.0 * body_m3 / wing.area_m2
    x_m = wing.quarter_m + (tail_slope_on_wing * planes.arm_m - body_m) / slope
    return NeutralPoint(x_m, slope, tail_slope, downwash)


class Trim(NamedTuple):
    """Steady flight without a pitching moment.

    ``tail_lift``: lift coefficient of the tail plane on its own area and pressure. ``wing_lift``:
    lift coefficient of the wing, which carries the rest. ``drag``: trim drag coefficient.
    """

    tail_lift: Value
    wing_lift: Value
    drag: Value


def trim(
    wing: Wing,
    tail: Tail,
    planes: TailPlanes,
    *,
    lift: Value,
    moment: float,
    gravity_x_m: Value,
    span_efficiency: Value,
) -> Trim:
    """Return the tail lift for zero pitching moment, and the trim drag.

    ``C_Lt = (C_M0 + C_L (x_cg - x_w)/c)/(eta V_h)`` (Etkin and Reid, eq. 2.3,6 with 2.3,14).
    The induced drag of both planes is Prandtl's of a biplane without gap,
    ``L_w^2/(pi q b_w^2) + 2 (b_t/b_w) L_w L_t/(pi q b_w b_t) + L_t^2/(pi q b_t^2)``: Laitone,
    E. V., Ideal Tail Load for Minimum Aircraft Drag, Journal of Aircraft 15 (1978), p. 190. All
    terms have the span efficiency of the drag polar.

    ``lift``: lift coefficient of the aircraft on the wing area. ``moment``: moment coefficient of
    the wing about its aerodynamic centre. ``gravity_x_m``: centre of gravity.
    """
    area = tail.dynamic_pressure_ratio * planes.horizontal_m2 / wing.area_m2
    lever = moment * wing.aerodynamic_chord_m + lift * (gravity_x_m - wing.quarter_m)
    on_wing_area = lever / planes.arm_m
    wing_lift = lift - on_wing_area
    per_lift = 1.0 / (pi * span_efficiency * wing.aspect_ratio)
    spans = (wing.wingspan_m / planes.horizontal_span_m) ** 2
    load = wing_lift**2 + 2.0 * wing_lift * on_wing_area
    load = load + spans * on_wing_area**2 / tail.dynamic_pressure_ratio
    return Trim(on_wing_area / area, wing_lift, per_lift * (load - lift**2))


def control_effectiveness(chord_fraction: float) -> float:
    """Return the change of the zero-lift angle per deflection of a hinged flap [-].

    ``1 - (theta - sin theta)/pi`` with ``cos theta = 2 c_f/c - 1``, thin airfoil theory, times 0.8
    for an unsealed hinge (Phillips, section 1.7); 1 for an all-moving plane.
    """
    theta = acos(2.0 * chord_fraction - 1.0)
    return 1.0 if chord_fraction == 1.0 else _HINGE * (1.0 - (theta - sin(theta)) / pi)


def elevator_deflection(
    tail: Tail, neutral: NeutralPoint, level: Trim, slow: Trim, lift_change: Value
) -> Value:
    """Return the elevator deflection for another lift coefficient, trailing edge down [rad].

    The elevator is neutral in level flight. It adds the change of tail lift between both trims that
    the angle of attack does not bring, ``a_t d alpha (1 - d eps/d alpha)``.

    ``lift_change`` is the difference of the lift coefficients of both trims.
    """
    by_angle = neutral.tail_slope * (1.0 - neutral.downwash) * lift_change / neutral.slope
    effect = neutral.tail_slope * control_effectiveness(tail.elevator_chord_fraction)
    return (slow.tail_lift - level.tail_lift - by_angle) / effect


def directional_stability(
    wing: Wing, tail: Tail, planes: TailPlanes, *, gravity_x_m: Value, body_m3: float
) -> tuple[Value, Value]:
    """Return ``dC_n/d beta`` [1/rad], and the yawing moment of the largest rudder deflection [-].

    Both are coefficients on wing area and span.

    Fins: ``a_v S_v l/(S b)`` times ``(1 + d sigma/d beta) eta`` of Raymer, eq. 16.47 and 16.48, at
    1.55 times their aspect ratio. Pods: ``-2 volume/(S b)`` as in pitch.
    """
    share = planes.vertical_m2 / wing.area_m2
    arm_m = wing.quarter_m + planes.vertical_arm_m - gravity_x_m
    slope = lift_slope(_FIN_END_PLATE * tail.vertical_aspect_ratio) * share * arm_m
    slope = slope / wing.wingspan_m
    sidewash = _SIDEWASH + _SIDEWASH_AREA * share + _SIDEWASH_RATIO * wing.aspect_ratio
    body = 2.0 * body_m3 / (wing.area_m2 * wing.wingspan_m)
    effect = control_effectiveness(tail.rudder_chord_fraction) * tail.dynamic_pressure_ratio
    deflection = tail.rudder_deflection_deg * pi / 180.0
    return slope * sidewash - body, slope * effect * deflection
