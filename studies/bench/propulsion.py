"""Thrust stands: efficiencies of propeller and motor of a chain of constant efficiencies.

With torque and speed the shaft's power is known: over the electric power it gives motor, gearbox
and controller together, also at airspeed zero; thrust times airspeed over it gives the propeller.
Without, thrust times airspeed over the electric power gives the whole chain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.propulsion.chain import Propulsion
from solar.types import BoolArray, FloatArray
from studies.bench.tables import BenchTable, Layout, Quantity
from studies.bench.values import Measured, linear_fit, parameter

LAYOUT = Layout(
    "thrust-stand",
    "Thrust stand or wind tunnel, near the speed and the thrust of level flight.",
    (
        Quantity("airspeed_m_per_s", "of the tunnel; 0 on a stand", 0, 200),
        Quantity("thrust_n", "of the propeller", 0, 1e4),
        Quantity("electric_power_w", "into the controller", 0.01, 1e6),
        Quantity("rpm", "of the propeller", 1, 1e5, optional=True),
        Quantity("torque_nm", "of the propeller's shaft", 1e-5, 1e4, optional=True),
    ),
    (
        (8.4, 2.60, 35.4, 1010, 0.255),
        (8.4, 2.71, 37.0, 1025, 0.264),
        (8.4, 2.52, 34.3, 1000, 0.248),
    ),
)  # fmt: skip
# Standard uncertainties of balances, torque cells, power meters and tunnels: assumptions.
FORCE_SIGMA, POWER_SIGMA, AIRSPEED_SIGMA = 0.01, 0.01, 0.01


def evaluate(table: BenchTable, aircraft: Aircraft) -> Sequence[Measured]:
    """Efficiencies that the rows determine."""
    names, moving = set(table.values), table["airspeed_m_per_s"] > 0.0
    if ("rpm" in names) != ("torque_nm" in names):
        raise table.refused("rpm and torque_nm give the shaft's power together: one is missing")
    thrust_w = table["thrust_n"] * table["airspeed_m_per_s"]
    frame = aircraft.airframe
    if isinstance(frame, MeasuredAirframe):
        if frame.level_flight.propulsion_efficiency is None:
            key = "airframe.level_flight.propulsion_efficiency"
            raise table.refused(f"{aircraft.name} has no {key}, which this test would change")
        whole = _ratio(table, "propulsion_efficiency", thrust_w, table["electric_power_w"], moving)
        return [whole]
    chain = frame.propulsion
    if not isinstance(chain, Propulsion):
        raise table.refused(
            f"{aircraft.name} has airframe.propulsion.kind {chain.kind}, whose efficiencies are "
            "computed (allowed: constant)"
        )
    rest = chain.efficiency / chain.propeller_efficiency
    if "rpm" not in names:
        return [
            _ratio(
                table, "propeller_efficiency", thrust_w / rest, table["electric_power_w"], moving
            )
        ]
    shaft_w = table["torque_nm"] * table["rpm"] * 2.0 * math.pi / 60.0
    before_motor = rest / chain.motor_efficiency
    every = np.ones(len(moving), bool)
    found = [
        _ratio(table, "motor_efficiency", shaft_w / before_motor, table["electric_power_w"], every)
    ]
    if moving.any():
        found.append(_ratio(table, "propeller_efficiency", thrust_w, shaft_w, moving))
    return found


def _ratio(
    table: BenchTable, name: str, useful_w: FloatArray, taken_w: FloatArray, use: BoolArray
) -> Measured:
    """Mean efficiency of the rows that are used."""
    if not use.any():
        raise table.refused("airspeed_m_per_s is 0 in all rows: allowed with rpm and torque_nm")
    ratio = useful_w[use] / taken_w[use]
    (value,), covariance, free = linear_fit(np.ones((len(ratio), 1)), ratio)
    of_speed = 0.0 if name == "motor_efficiency" else AIRSPEED_SIGMA
    relative = float(np.sqrt(FORCE_SIGMA**2 + POWER_SIGMA**2 + of_speed**2))
    rows = "1 row" if len(ratio) == 1 else f"{len(ratio)} rows"
    notes = (
        f"{table.source}: {rows}; force, power and airspeed right to {FORCE_SIGMA:.0%} each "
        "(assumptions)",
    )
    scatter = math.sqrt(float(covariance[0, 0]))
    return Measured(parameter(name), float(value), scatter, free, relative * float(value), notes)
