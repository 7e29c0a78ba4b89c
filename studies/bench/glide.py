"""Glide polars: drag of an aircraft from airspeed and rate of sink, propellers folded.

In a steady glide the drag over the lift is the tangent of the angle of glide. The drag coefficient
is ``C_D0 + C_L^2 / (pi e AR)``; lift coefficients that differ enough determine ``e`` as well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from missions.air import GRAVITY_M_PER_S2, ZERO_CELSIUS_K, air_at
from sizing.aerodynamics.parabolic import DragPolar
from sizing.aircraft import Aircraft, MeasuredAirframe
from solar.types import FloatArray
from studies.bench.tables import BenchTable, Layout, Quantity
from studies.bench.values import Measured, linear_fit, parameter

LAYOUT = Layout(
    "glide-polar",
    "Steady glides with the propeller folded, in calm air, means over a minute or more each.",
    (
        Quantity("airspeed_m_per_s", "true, along the path", 1, 200),
        Quantity("sink_rate_m_per_s", "through the air", 0.01, 50),
        Quantity("mass_kg", "of the aircraft", 0.01, 1e5),
        Quantity("density_kg_per_m3", "of the air", 0.01, 2),
        Quantity("temperature_c", "of the air", -90, 60),
    ),
    (
        (7.6, 0.292, 6.92, 1.16, 18),
        (8.4, 0.300, 6.92, 1.16, 18),
        (9.5, 0.345, 6.92, 1.16, 18),
        (11.0, 0.447, 6.92, 1.16, 18),
        (12.5, 0.602, 6.92, 1.16, 18),
    ),
)
# Standard uncertainties of a calibrated airspeed and of the rate of sink by a barometer, common to
# all rows: assumptions.
AIRSPEED_SIGMA, SINK_SIGMA = 0.02, 0.01
_LEAST_SPAN = 1.5  # largest over least lift coefficient, squared: below, e is that of the file


def evaluate(table: BenchTable, aircraft: Aircraft) -> Sequence[Measured]:
    """Drag of a parametric aircraft, or level power of a measured one."""
    frame = aircraft.airframe
    span, ratio = float(frame.wingspan_m), float(frame.aspect_ratio)
    speed, sink, density = (
        table[name] for name in ("airspeed_m_per_s", "sink_rate_m_per_s", "density_kg_per_m3")
    )
    if (sink >= speed).any():
        line = table.lines[int(np.argmax(sink >= speed))]
        raise table.refused(f"line {line}: sink_rate_m_per_s must be less than airspeed_m_per_s")
    angle = np.arcsin(sink / speed)
    weight = table["mass_kg"] * GRAVITY_M_PER_S2
    lift = weight * np.cos(angle) / (0.5 * density * speed**2 * span**2 / ratio)
    drag = lift * np.tan(angle)
    if isinstance(frame, MeasuredAirframe):
        return [_level_power(table, frame, lift, drag)]
    polar = frame.aerodynamics
    if not isinstance(polar, DragPolar):
        raise table.refused(
            f"{aircraft.name} has airframe.aerodynamics.model {polar.model}, whose drag is "
            "computed (allowed: parabolic)"
        )
    air = air_at(table["temperature_c"] + ZERO_CELSIUS_K, 1e5)  # viscosity knows no pressure
    reynolds = density * speed * (span / ratio) / air.dynamic_viscosity_pa_s
    profile = (reynolds / polar.reference_reynolds) ** -polar.reynolds_exponent
    left = drag - polar.parasitic_drag_coefficient
    both = bool((lift**2).max() > _LEAST_SPAN * (lift**2).min()) and len(lift) > 2
    if both:
        found, covariance, free = linear_fit(np.stack([profile, lift**2], axis=1), left)
    else:
        induced = lift**2 / (math.pi * polar.span_efficiency * ratio)
        found, covariance, free = linear_fit(profile[:, np.newaxis], left - induced)
    errors = np.sqrt(np.diag(covariance))
    # Drag by its instruments: the sink, and the speed, which lift and drag have as its third power.
    relative = math.hypot(SINK_SIGMA, 3.0 * AIRSPEED_SIGMA)
    of_drag = relative * float((left / profile).mean())
    notes = _notes(table)
    measured = [
        Measured(
            *(parameter("profile_drag"), float(found[0]), float(errors[0]), free, of_drag),
            notes=notes,
        )
    ]
    if both and found[1] > 0.0:
        efficiency = 1.0 / (math.pi * ratio * float(found[1]))
        parts = (efficiency * float(errors[1] / found[1]), free, relative * efficiency)
        measured.append(Measured(parameter("span_efficiency"), efficiency, *parts))
    return measured


def _level_power(
    table: BenchTable, frame: MeasuredAirframe, lift: FloatArray, drag: FloatArray
) -> Measured:
    """Electric power at the mass, the density and the airspeed of the file."""
    level = frame.level_flight
    for key in ("airspeed_m_per_s", "propulsion_efficiency"):
        if getattr(level, key) is None:
            message = f"the aircraft has no airframe.level_flight.{key}, which this test needs"
            raise table.refused(message)
    assert level.airspeed_m_per_s is not None
    assert level.propulsion_efficiency is not None
    pressure = 0.5 * level.density_kg_per_m3 * level.airspeed_m_per_s**2
    area = frame.wingspan_m**2 / frame.aspect_ratio
    wanted = level.mass_kg * GRAVITY_M_PER_S2 / (pressure * area)
    if len(lift) < 3 or not lift.min() * 0.9 <= wanted <= lift.max() * 1.1:
        raise table.refused(
            f"lift coefficients {lift.min():.2f} to {lift.max():.2f} in {len(lift)} rows do not "
            f"enclose that of level flight, {wanted:.2f} (allowed: 3 rows or more around it)"
        )
    found, covariance, free = linear_fit(np.stack([np.ones(len(lift)), lift**2], axis=1), drag)
    at = np.array([1.0, wanted**2])
    watts = pressure * area * level.airspeed_m_per_s / level.propulsion_efficiency
    value = watts * float(found @ at)
    scatter = watts * math.sqrt(float(at @ covariance @ at))
    relative = math.hypot(SINK_SIGMA, 3.0 * AIRSPEED_SIGMA)
    notes = (
        *_notes(table),
        f"propulsion efficiency {level.propulsion_efficiency:g} as in the file",
    )
    return Measured(parameter("level_power"), value, scatter, free, relative * value, notes)


def _notes(table: BenchTable) -> tuple[str, ...]:
    return (
        f"{table.source}: {len(table.lines)} glides; airspeed right to {AIRSPEED_SIGMA:.0%}, rate "
        f"of sink to {SINK_SIGMA:.0%} (assumptions)",
    )
