"""What the propulsion's efficiency of the moment changes against that of level flight."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sizing.aircraft import Aircraft
from sizing.design import load_profile
from sizing.energy.cycle import simulate_cycle
from sizing.performance import Performance
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.results.records import finite
from sizing.varying_load import flight_of, interpolation_error, load_shape

# Of the power: an error that would show in the efficiency as it is printed.
_TOLD_ERROR = 1e-3


@dataclass(frozen=True)
class Instant:
    """Propulsion at an instant of the day, computed by the exact chain.

    ``hour``: solar time [h]. ``load``: thrust power over that of level flight [-]. ``efficiency``:
    thrust power over bus power [-], NaN where the parts cannot do it, for a ``reason``.
    """

    hour: float
    load: float
    state_of_charge: float
    bus_voltage_v: float
    efficiency: float
    reason: str


@dataclass(frozen=True)
class VaryingEfficiency:
    """Scenario of least excess time, by the efficiency of the moment and by that of level flight.

    ``level_excess_time_h``, ``level_minimum_state_of_charge``: by that of level flight at the
    voltage that takes more. ``night``, ``most``: where the charge and where the load are least and
    most; ``most`` is None for a load that does not vary. ``interpolation_error``: largest one of
    the table, relative to the power, half-way between its nodes.
    """

    excess_time_h: float
    level_excess_time_h: float
    minimum_state_of_charge: float
    level_minimum_state_of_charge: float
    night: Instant
    most: Instant | None
    interpolation_error: float

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready; null where a number is unlimited or not defined."""

        def plain(value: Any) -> Any:
            if isinstance(value, dict):
                return {key: plain(one) for key, one in value.items()}
            return finite(value) if isinstance(value, float) else value

        record: dict[str, Any] = plain(asdict(self))
        return record


def varying_efficiency(aircraft: Aircraft, flown: Performance) -> VaryingEfficiency | None:
    """Effect of the efficiency of the moment on a single design; None where it is constant."""
    propulsion = getattr(aircraft.airframe, "propulsion", None)
    if not isinstance(propulsion, OperatingPointPropulsion):
        return None
    design, mission, at = flown.design, flown.mission, flown.worst_scenario()
    day = flown.day.at([at])
    level = simulate_cycle(
        day.time_h,
        flown.solar_power_w[[at]],
        load_profile(day.time_h, design, mission, day.sunrise_h, day.sunset_h),
        flown.store.flat(flown.cycle.status.shape).select(slice(at, at + 1)),
        nominal_load_w=design.nominal_load_w(mission),
    )
    charge = flown.cycle.energy_wh[at] / float(np.ravel(flown.store.battery_energy_wh)[0])
    volts = aircraft.battery.bus_voltage_v(charge)
    load = load_shape(mission, day)[0]
    own, flight = flight_of(aircraft, mission, design)

    def instant(node: int) -> Instant:
        bus_v = float(volts[node])
        point = own.point(flight.thrust_w * load[node], *flight[1:], (bus_v, bus_v))
        hour, share, soc = (float(one[node]) for one in (day.time_h, load, charge))
        return Instant(hour, share, soc, bus_v, float(point.efficiency), str(point.reason))

    varies = np.ptp(load) > 0.0
    return VaryingEfficiency(
        excess_time_h=float(flown.cycle.excess_time_h[at]),
        level_excess_time_h=float(level.excess_time_h[0]),
        minimum_state_of_charge=float(flown.cycle.minimum_state_of_charge[at]),
        level_minimum_state_of_charge=float(level.minimum_state_of_charge[0]),
        night=instant(int(np.argmin(charge))),
        most=instant(int(np.argmax(load))) if varies else None,
        interpolation_error=interpolation_error(aircraft, mission, design),
    )


def varying_line(found: VaryingEfficiency) -> str:
    """Effect of the efficiency of the moment in a sentence or some."""
    ours, theirs = found.excess_time_h, found.level_excess_time_h
    hours = f"excess time {ours:.2f} h" if np.isfinite(ours) else "unlimited excess time"
    night = found.night
    parts = [
        f"propulsion at the load and voltage of the moment: {hours}, {theirs:.2f} h by level "
        f"flight's efficiency; {_told(night)} at {night.bus_voltage_v:.1f} V at the end of the "
        f"night, {100.0 * night.state_of_charge:.0f} % charge"
    ]
    if (most := found.most) is not None:
        parts.append(
            f", {_told(most)} at {most.bus_voltage_v:.1f} V in thermals, {most.load:.2f} times the "
            "power of level flight"
        )
    if found.interpolation_error > _TOLD_ERROR:
        parts.append(f"; the table of the march is {found.interpolation_error:.1e} off")
    reasons = [one.reason for one in (found.night, found.most) if one is not None and one.reason]
    return "".join([*parts, ".", *(f" Beyond the parts: {reason}." for reason in reasons[:1])])


def _told(instant: Instant) -> str:
    known = np.isfinite(instant.efficiency)
    return f"{100.0 * instant.efficiency:.1f} %" if known else "beyond what the parts can do"
