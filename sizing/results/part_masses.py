"""Masses of the propulsion's parts that are estimated, with what they scatter by."""

from __future__ import annotations

from typing import Any, NamedTuple

from sizing.aircraft import Aircraft
from sizing.design import Design
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.part_masses import motor_mass_fit

__all__ = ["PartMasses", "part_masses", "part_masses_line"]


class PartMasses(NamedTuple):
    """Estimated masses of one propulsor [kg]; None for a part whose mass is known.

    ``motor_scatter``: one standard deviation of the motors of the catalogue, as a factor.
    """

    motor_kg: float | None
    motor_scatter: float | None
    gearbox_kg: float | None

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return self._asdict()


def part_masses(aircraft: Aircraft, design: Design) -> PartMasses | None:
    """Estimated masses of a design's propulsion; None where there are none."""
    propulsion, chain = getattr(aircraft.airframe, "propulsion", None), design.chain
    if not isinstance(propulsion, OperatingPointPropulsion) or not propulsion.estimates_masses:
        return None
    assert chain is not None
    own = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    # Wound anew it has the mass that it had.
    motor = None if propulsion.own_motor.mass_kg is not None else propulsion.motor_mass_kg
    gears_kg = float(design.masses.propulsion) - float(chain.fixed_mass_kg or 0.0)
    has_gear = own.gear.mass_kg is None and own.gear.ratio != 1.0
    if motor is None and not has_gear:
        return None
    return PartMasses(
        motor_kg=motor,
        motor_scatter=None if motor is None else motor_mass_fit().scatter,
        gearbox_kg=gears_kg / own.propulsors if has_gear else None,
    )


def part_masses_line(found: PartMasses) -> str:
    """Estimated masses in a sentence."""
    parts = []
    if found.motor_kg is not None and found.motor_scatter is not None:
        low, high = found.motor_kg / found.motor_scatter, found.motor_kg * found.motor_scatter
        parts.append(
            f"motor {found.motor_kg:.3f} kg by the torque of {motor_mass_fit().motors} motors of "
            f"the catalogue, which scatter by a factor of {found.motor_scatter:.2f} "
            f"({low:.3f} to {high:.3f} kg)"
        )
    if found.gearbox_kg is not None:
        parts.append(f"gearbox {found.gearbox_kg:.3f} kg by its torque (NASA/TM-2009-215680)")
    return f"estimated masses of a propulsor: {', '.join(parts)}."
