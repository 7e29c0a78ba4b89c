"""Assessment of a rib wing: sizing criteria, deflections, twist and V-n diagram.

The flight envelope (V-n diagram) has load factors over equivalent airspeed: manoeuvre and gust
envelopes of CS 23.333, with the gust speeds and speed ratios of the structure's file.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees

import numpy as np
from numpy.typing import ArrayLike

from missions.air import GRAVITY_M_PER_S2
from sizing.smooth import Value, largest
from sizing.structures.loads import (
    SEA_LEVEL_DENSITY_KG_PER_M3,
    Station,
    StructureInputs,
    gust_load_increment,
)
from sizing.structures.rib_wing import RibWingStructure
from solar.types import FloatArray


@dataclass(frozen=True)
class FlightEnvelope:
    """Airspeeds [m/s, equivalent] and load factors, all positive [-], of an aircraft.

    Level flight is taken as cruise. ``*_gust_increment``: of the gusts at these speeds.
    ``*limit_load_factor``: those that size the structure.
    """

    stall_speed_m_per_s: float
    cruise_speed_m_per_s: float
    dive_speed_m_per_s: float
    manoeuvre_load_factor: float
    negative_manoeuvre_load_factor: float
    cruise_gust_increment: float
    dive_gust_increment: float
    limit_load_factor: float
    negative_limit_load_factor: float

    def manoeuvre(self, airspeed_m_per_s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the largest load factors of manoeuvres, upwards and downwards (negative) [-].

        The maximum lift coefficient limits both to ``(V/V_s)^2``, and is assumed equal downwards.
        The downward limit falls linearly to 0 from cruise to dive speed, CS 23.333 (b).
        """
        airspeed = np.asarray(airspeed_m_per_s, float)
        stalled = (airspeed / self.stall_speed_m_per_s) ** 2
        fading = np.interp(airspeed, (self.cruise_speed_m_per_s, self.dive_speed_m_per_s), (1, 0))
        up = np.minimum(stalled, self.manoeuvre_load_factor)
        return up, -np.minimum(stalled, fading * self.negative_manoeuvre_load_factor)

    @property
    def gusts(self) -> tuple[tuple[float, float], ...]:
        """Airspeed [m/s] and increment [-] of the gusts at cruise and at dive speed."""
        return (
            (self.cruise_speed_m_per_s, self.cruise_gust_increment),
            (self.dive_speed_m_per_s, self.dive_gust_increment),
        )


def flight_envelope(
    model: RibWingStructure, inputs: StructureInputs, maximum_lift_coefficient: float
) -> FlightEnvelope:
    """Return the flight envelope of a rib wing, with inputs that are numbers."""
    wing = model.wing(inputs)
    mass_kg, cruise = float(inputs.total_mass_kg), float(wing.equivalent_airspeed_m_per_s)
    dynamic = 0.5 * SEA_LEVEL_DENSITY_KG_PER_M3 * wing.wing_area_m2 * maximum_lift_coefficient
    dive, pull_up = model.dive_speed_ratio * cruise, float(model.pull_up(mass_kg))
    fraction = float(inputs.gust_fraction) if model.gusts_fall_with_altitude else 1.0
    increments = [
        float(gust_load_increment(fraction * gust * airspeed, inputs))
        for gust, airspeed in ((model.cruise_gust_m_per_s, cruise), (model.dive_gust_m_per_s, dive))
    ]
    return FlightEnvelope(
        stall_speed_m_per_s=float((mass_kg * GRAVITY_M_PER_S2 / dynamic) ** 0.5),
        cruise_speed_m_per_s=cruise,
        dive_speed_m_per_s=dive,
        manoeuvre_load_factor=pull_up,
        negative_manoeuvre_load_factor=model.negative_load_ratio * pull_up,
        cruise_gust_increment=increments[0],
        dive_gust_increment=increments[1],
        limit_load_factor=float(wing.factor_up),
        negative_limit_load_factor=float(wing.factor_down),
    )


# Criteria in words that are not those of their keys.
_LABELS = {
    "compression": "compression strength",
    "tension": "tensile strength",
    "shear": "shear strength",
    "gauge": "minimum gauge",
    "tip_slope": "slope of the tip",
    "landing_deflection": "tip deflection in landing",
    "twist_in_dive": "twist in a dive",
}


@dataclass(frozen=True)
class Torsion:
    """Torsional stiffness of a wing, and its critical speeds.

    ``stiffness_nm2``: lower bound of GJ. ``needed_nm2``: GJ required by the criteria.
    ``divergence_speed_ratio``: over dive speed; None where the wing cannot diverge.
    ``flutter_flexibility_ratio``: over the largest that Report 45 allows. Twist is the tip's.
    """

    stiffness_nm2: float
    needed_nm2: float
    divergence_speed_ratio: float | None
    flutter_flexibility_ratio: float
    twist_at_limit_load_deg: float


# Criteria without a load case, or with the load case in their name.
_WITHOUT_CASE = ("gauge", "tip_deflection", "tip_slope", "landing_deflection")


@dataclass(frozen=True)
class StructureAssessment:
    """Sizing criteria of spar and nose, and the resulting stiffness.

    Load factors are all positive; load cases ``gust`` or ``manoeuvre``. ``spar_caps``,
    ``spar_web``: share of the mass that each criterion sizes [-], largest first;
    ``spar_caps_case``: load case under which the first one sizes most of the caps. Deflections are
    over the half-span, in level flight, at the upward limit load, and downwards in landing.
    ``torsion``: None without requirements. Batteries lie in spar and pod. ``remarks``: loads that
    the criteria do not cover, and keys whose meaning has changed.
    """

    limit_load_factor: float
    load_case: str
    negative_limit_load_factor: float
    negative_load_case: str
    landing_load_factor: float
    spar_caps: dict[str, float]
    spar_caps_case: str
    spar_web: dict[str, float]
    nose: str
    tip_deflection_1g: float
    tip_deflection_limit: float
    tip_deflection_landing: float
    tip_slope_1g_deg: float
    tip_slope_limit_deg: float
    torsion: Torsion | None
    wing_battery_kg: float
    pod_battery_kg: float
    remarks: tuple[str, ...] = ()
    flight_envelope: FlightEnvelope | None = None

    def headline(self) -> str:
        """Return a line with sizing criteria, load cases and deflections."""
        caps, web = next(iter(self.spar_caps)), next(iter(self.spar_web))
        names = (_LABELS.get(key, key.replace("_", " ")) for key in (caps, web, self.nose))
        of_caps, of_web, of_nose = names
        case = "" if caps in _WITHOUT_CASE else f" in {self.spar_caps_case}"
        factors = (self.limit_load_factor, -self.negative_limit_load_factor)
        up, down, landing = (round(factor, 1) for factor in (*factors, self.landing_load_factor))
        other = f" g ({self.load_case})" if self.load_case != self.negative_load_case else ""
        bent = (self.tip_deflection_1g, self.tip_deflection_limit, -self.tip_deflection_landing)
        level, limit, landed = (f"{round(100.0 * deflection, 1)} %" for deflection in bent)
        return (
            f"structure: spar caps sized by {of_caps}{case} "
            f"({round(100.0 * self.spar_caps[caps])} %), webs by {of_web}, nose by "
            f"{of_nose}; limit loads {up}{other} and {down} g "
            f"({self.negative_load_case}), landing {landing} g; tip deflection {level} at 1 g, "
            f"{limit} at the limit load, {landed} in landing"
        )


def assess(model: RibWingStructure, inputs: StructureInputs) -> StructureAssessment:
    """Return the assessment of a rib wing from inputs that are floats."""
    inputs = StructureInputs(*(float(value) for value in inputs))
    wing = model.wing(inputs)
    station, integral = model.along_the_span(wing.wingspan_m)
    forces = model.cap_forces(wing, station)
    needs = model.cap_needs_m2(wing, forces)
    up, down = float(wing.factor_up), float(wing.factor_down)
    pull_up = float(model.pull_up(wing.total_mass_kg))
    gust_up, gust_down = up > 1.01 * pull_up, down > 1.01 * model.negative_load_ratio * pull_up
    cases = {
        "an up-gust" if gust_up else "a pull-up": forces.up,
        "a down-gust" if gust_down else "a push-over": forces.down,
        "landing": forces.landing,
    }
    caps = _shares(needs, station)
    nose, torsion, twisted = "gauge", model.torsion, None
    if torsion is not None:
        needed = {k: float(v) for k, v in model.torsional_needs_nm2(wing).items()}
        largest_need = max(needed, key=lambda name: needed[name])
        if model.torsional_stiffness_nm2(wing, wing.sheet_m) < needed[largest_need]:
            nose = largest_need
        sheet_m = wing.sheet_m + model.stiffening_sheet_m(wing)
        stiffness = float(model.torsional_stiffness_nm2(wing, sheet_m))
        diverging = needed["divergence"] / torsion.speed_margin**2
        twist = torsion.maximum_twist_deg * needed["twist_at_limit_load"] / stiffness
        twisted = Torsion(
            stiffness_nm2=stiffness,
            needed_nm2=max(needed.values()),
            divergence_speed_ratio=None if diverging == 0.0 else (stiffness / diverging) ** 0.5,
            flutter_flexibility_ratio=needed["flutter"] / stiffness,
            twist_at_limit_load_deg=twist,
        )
    level = GRAVITY_M_PER_S2 * model.net_moment(wing, station, station.wire)
    landing = GRAVITY_M_PER_S2 * wing.relief_kg * station.landed_moment
    # Tip deflection over the half-span and slope of the tip, by beam theory.
    upper_m2, lower_m2 = (largest(each) for each in needs)
    half_span = wing.wingspan_m / 2.0
    section = upper_m2 * lower_m2 / (upper_m2 + lower_m2)
    compliance = half_span / 2.0 / (model.modulus_pa * wing.depth_m**2 * section)
    bent_1g, bent_landing = (
        float(integral(load * compliance * (1.0 - station.fraction)) * half_span)
        for load in (level, landing)
    )
    turned_1g = degrees(float(integral(level * compliance) * half_span))
    return StructureAssessment(
        limit_load_factor=up,
        load_case="gust" if gust_up else "manoeuvre",
        negative_limit_load_factor=down,
        negative_load_case="gust" if gust_down else "manoeuvre",
        landing_load_factor=model.landing_load_factor,
        spar_caps=caps,
        spar_caps_case=_case(next(iter(caps)), needs, station, cases),
        spar_web=_shares((model.web_needs_m(wing, model.shear_n(wing, station)),), station),
        nose=nose,
        tip_deflection_1g=bent_1g,
        tip_deflection_limit=up * bent_1g,
        tip_deflection_landing=model.landing_load_factor * bent_landing,
        tip_slope_1g_deg=turned_1g,
        tip_slope_limit_deg=up * turned_1g,
        torsion=twisted,
        wing_battery_kg=inputs.wing_battery_kg + inputs.pod_battery_kg - float(wing.pod_battery_kg),
        pod_battery_kg=float(wing.pod_battery_kg),
    )


def _shares(needs: tuple[dict[str, Value], ...], station: Station) -> dict[str, float]:
    """Return the shares of material sized by each criterion, largest first."""
    shares: dict[str, float] = {}
    for each in needs:
        table = np.array([np.broadcast_to(need, station.weight.shape) for need in each.values()])
        for name, size, weight in zip(
            np.array(list(each))[table.argmax(axis=0)],
            table.max(axis=0),
            station.weight,
            strict=True,
        ):
            shares[str(name)] = shares.get(str(name), 0.0) + float(size * weight)
    total = sum(shares.values())
    return {name: shares[name] / total for name in sorted(shares, key=lambda n: -shares[n])}


def _case(
    criterion: str, needs: tuple[dict[str, Value], ...], station: Station, cases: dict[str, Value]
) -> str:
    """Return the load case in which a criterion of strength sizes most of the caps."""
    names = list(cases)
    _, down, landing = (np.broadcast_to(force, station.weight.shape) for force in cases.values())
    downwards = np.where(landing > down, 2, 1)
    # A load that compresses one cap stretches the other.
    by_cap = (np.zeros_like(downwards), downwards)
    sized: dict[str, float] = dict.fromkeys(names, 0.0)
    for cap, each in enumerate(needs):
        case_at = by_cap[1 - cap] if criterion == "tension" else by_cap[cap]
        size = np.broadcast_to(each[criterion], station.weight.shape)
        for case, part in zip(case_at, size * station.weight, strict=True):
            sized[names[case]] += float(part)
    return max(sized, key=lambda name: sized[name])
