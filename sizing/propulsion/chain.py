"""Propulsion of an aircraft's file: a chain of constants, or parts at their operating point."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from math import prod
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    Strict,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

from missions.air import Air, plain_number
from sizing.catalogues.choice import (
    CatalogueRecord,
    CatalogueValue,
    Kind,
    catalogue_values,
    entry_of_key,
)
from sizing.parameters import all_replaced
from sizing.propulsion import part_masses
from sizing.propulsion.electric import Controller, Gear, Motor
from sizing.propulsion.operating_point import (
    OperatingPoint,
    Propulsor,
    Shaft,
    point_behind,
    shaft_at,
)
from sizing.propulsion.propeller_files import PropellerChoice
from sizing.smooth import Value
from sizing.user_models import user_function
from solar.schema import (
    Fraction,
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Record,
    Text,
    wrong_value,
)

_MassFactor = Annotated[float, Strict(), Field(gt=0.0, le=20.0)]
# Default of rated over level-flight power; AtlantikSolar has 180 W over 35.8 W.
_CLIMB_POWER_RATIO = 5.0
_MASS_KG_PER_W = 0.0011
# At a constant advance ratio power scales with the cube of propeller speed, torque with the square.
_GEAR_BY_POWER = part_masses.GEAR_EXPONENT * 2.0 / 3.0
# Links of the chain from the bus to the air, and their names in an operating point.
LINKS = {
    "wiring": "wiring",
    "controller": "controller",
    "motor": "motor",
    "gearbox": "gear",
    "propeller": "propeller",
}

_MassModel = Annotated[
    Text, AfterValidator(lambda name: user_function("propulsion_mass", name) and name)
]
_EfficiencyModel = Annotated[
    Text, AfterValidator(lambda name: user_function("propulsion_efficiency", name) and name)
]
_ClimbRatio = Annotated[float, Strict(), Field(ge=1.0)]
_RATINGS = {"climb_rate_m_per_s": "climb_power_ratio"}


def _one_link(efficiency: Value) -> dict[str, Any]:
    """Return the efficiencies of a chain with its propeller as the only link."""
    return {f"{name}_efficiency": 1.0 for name in LINKS} | {"propeller_efficiency": efficiency}


class Propulsion(CatalogueRecord):
    """Propulsion chain from the battery bus to thrust power, and its mass.

    The group's mass follows its rated electric power: level flight's times ``climb_power_ratio``
    (5 by default), or what climbing at ``climb_rate_m_per_s`` takes at the airspeed of level
    flight, ``P_level + m g v_climb / efficiency``. One of the two, not both. ``fixed_mass_kg`` does
    not scale with the power.

    ``motor`` names an entry of the catalogue of motors, which gives the motor's best efficiency at
    ``motor_voltage_v``. ``mass_model`` names a user-defined mass model, instead of
    ``mass_kg_per_w``: see :func:`sizing.register_propulsion_mass`. ``efficiency_model`` names a
    user-defined model of the efficiency of the whole chain, instead of its links: see
    :func:`sizing.register_propulsion_efficiency`.
    """

    _entries: ClassVar[Mapping[str, Kind]] = {"motor": "motors"}
    _in_place_of: ClassVar[Mapping[str, str]] = _RATINGS
    # Constants have no operating points, limits or sizes.
    is_exact: ClassVar[bool] = False
    is_limited: ClassVar[bool] = False
    limit_names: ClassVar[tuple[str, ...]] = ()
    sizes: ClassVar[tuple[Value, ...]] = ()

    kind: Literal["constant"] = "constant"
    motor: Text | None = None
    motor_voltage_v: PositiveReal | None = None
    wiring_efficiency: Fraction | None = None
    controller_efficiency: Fraction = 0.97
    motor_efficiency: Fraction = 0.82
    gearbox_efficiency: Fraction = 0.96
    propeller_efficiency: Fraction = 0.82
    fixed_mass_kg: NonNegativeReal | None = None
    mass_kg_per_w: NonNegativeReal = _MASS_KG_PER_W
    climb_power_ratio: _ClimbRatio | None = None
    climb_rate_m_per_s: PositiveReal | None = None
    mass_model: _MassModel | None = None
    efficiency_model: _EfficiencyModel | None = None

    def sized(self, *_: Value | None) -> Self:
        """Return the chain, whose efficiencies are the same at any size."""
        return self

    def without_limits(self) -> Self:
        """Return the chain, which has none."""
        return self

    def first_chain(self) -> Propulsion:
        """Return the chain with which a search of the operating point begins: it is known."""
        return self

    def catalogue_values(self) -> list[CatalogueValue]:
        """Return the values from the catalogue of motors, with their sources."""
        return catalogue_values(self, "airframe.propulsion.")

    def in_flight(
        self,
        thrust_power_w: Value,
        airspeed_m_per_s: Value,
        air: Air,
        bus_voltage_v: tuple[float, float] | None,
    ) -> Propulsion:
        """Return the chain with the efficiency of the user-defined model, if any, as one link."""
        if self.efficiency_model is None:
            return self
        model = user_function("propulsion_efficiency", self.efficiency_model)
        efficiency = model(thrust_power_w, airspeed_m_per_s, air.density_kg_per_m3)
        return self.model_copy(update=_one_link(efficiency) | {"efficiency_model": None})

    def rated_power_w(self, level_w: Value, *, weight_n: Value) -> Value:
        """Return the rated electric power [W].

        ``level_w + weight_n v_climb / efficiency`` where a climb rate is given, else the climb
        power ratio times ``level_w``.
        """
        if self.climb_rate_m_per_s is not None:
            return level_w + weight_n * self.climb_rate_m_per_s / self.efficiency
        ratio = self.climb_power_ratio
        return (_CLIMB_POWER_RATIO if ratio is None else ratio) * level_w

    def mass_kg(self, rated_w: Value) -> Value:
        """Return the mass of the propulsion group for a rated electric power [kg]."""
        if self.mass_model is not None:
            mass_kg = user_function("propulsion_mass", self.mass_model)(rated_w)
        else:
            mass_kg = self.mass_kg_per_w * rated_w
        return mass_kg if self.fixed_mass_kg is None else self.fixed_mass_kg + mass_kg

    @property
    def links(self) -> dict[str, Value]:
        """Efficiency of each of :data:`LINKS` [-]; 1 for a link that the chain lacks."""
        named = {name: getattr(self, f"{name}_efficiency") for name in LINKS}
        return {name: 1.0 if value is None else value for name, value in named.items()}

    def mapped(self, function: Callable[[Value], Value]) -> Self:
        """Return the chain with a function applied to every efficiency."""
        links = {f"{name}_efficiency": function(value) for name, value in self.links.items()}
        return self.model_copy(update=links)

    @property
    def efficiency(self) -> Value:
        """Efficiency of the whole chain [-]."""
        return prod(self.links.values())


class OperatingPointPropulsion(Record):
    """Propellers, gears, motors and controllers with efficiencies computed in level flight.

    Equal ``propulsors`` share the thrust. ``motor`` is the name of a catalogue entry, the path of a
    user-defined entry, or the motor's constants. Masses are of the parts of one propulsor;
    ``mass_kg_per_w`` is added, and is 0 by default where the motor's mass is known.
    ``efficiency_factor`` is actual over computed efficiency of the propellers;
    ``motor_mass_factor`` and ``propeller_mass_factor`` are actual over given or estimated mass.
    """

    # Whether operating points are exact, and too slow to evaluate at every step for many designs.
    is_exact: ClassVar[bool] = True
    # Whether the limits of the parts make operating points infeasible.
    is_limited: ClassVar[bool] = True

    _in_place_of: ClassVar[Mapping[str, str]] = _RATINGS

    kind: Literal["operating_point"]
    propulsors: PositiveInteger = 1
    propeller: PropellerChoice
    gear: Gear = Gear()
    motor: Text | Motor
    controller: Controller
    wiring_resistance_ohm: NonNegativeReal = 0.0
    maximum_tip_mach: Annotated[float, Strict(), Field(gt=0.0, lt=1.0)] = 0.7
    efficiency_factor: Annotated[float, Strict(), Field(gt=0.0, le=1.5)] = 1.0
    motor_mass_factor: _MassFactor = 1.0
    propeller_mass_factor: _MassFactor = 1.0
    mass_kg_per_w: NonNegativeReal | None = None
    climb_power_ratio: _ClimbRatio | None = None
    climb_rate_m_per_s: PositiveReal | None = None
    mass_model: _MassModel | None = None

    @model_validator(mode="after")
    def _check_motor(self) -> OperatingPointPropulsion:
        if isinstance(self.motor, str):
            entry_of_key("motor", "motors", self.motor)
        return self

    def sized(
        self,
        diameter_m: Value | None,
        pitch_m: Value | None,
        gear_ratio: Value | None,
        speed_constant_rpm_per_v: Value | None = None,
    ) -> Self:
        """Return these parts with another diameter and pitch [m], gear ratio and motor winding.

        None keeps the value of the file. Rewinding does not change the motor's mass.
        """
        sizes: dict[str, Any] = {
            "propeller.diameter_m": diameter_m,
            "propeller.pitch_m": pitch_m,
            "gear.ratio": gear_ratio,
        }
        if diameter_m is not None and self.propeller.mass_kg:
            # The mass in the file belongs to the diameter in the file.
            larger = diameter_m / self.propeller.diameter_m
            grown = larger ** part_masses.propeller_mass_fit().exponent
            sizes["propeller.mass_kg"] = self.propeller.mass_kg * grown
        if speed_constant_rpm_per_v is not None:
            wound = self.motor_constants.rewound(speed_constant_rpm_per_v)
            sizes["motor"] = all_replaced(wound, {"mass_kg": self.motor_mass_kg})
        chosen: dict[str, Any] = {k: value for k, value in sizes.items() if value is not None}
        if diameter_m is not None or pitch_m is not None:
            chosen["propeller.product"] = None  # the product has another size
        return all_replaced(self, chosen) if chosen else self

    @cached_property
    def motor_constants(self) -> Motor:
        """Motor of the file, or of the catalogue entry that the file names."""
        return Motor.from_catalogue(self.motor) if isinstance(self.motor, str) else self.motor

    @cached_property
    def propulsor(self) -> Propulsor:
        """Propeller, gear, motor, controller and wiring; all propulsors are equal."""
        return Propulsor(
            propeller=self.propeller.propeller,
            motor=self.motor_constants,
            controller=self.controller,
            gear=self.gear,
            wiring_resistance_ohm=self.wiring_resistance_ohm,
            maximum_tip_mach=self.maximum_tip_mach,
            limited=self.is_limited,
        )

    @property
    def sizes(self) -> tuple[Value | None, ...]:
        """Sizes as the file has them, in the order of :meth:`sized`."""
        shaft = self.propeller.diameter_m, self.propeller.pitch_m, self.gear.ratio
        return *shaft, self.motor_constants.speed_constant_rpm_per_v

    @property
    def limit_names(self) -> tuple[str, ...]:
        """Names of the limits that the parts have."""
        motor = self.motor_constants
        limits = {"motor_current": motor.maximum_current_a, "motor_power": motor.maximum_power_w}
        known = (name for name, most in limits.items() if most is not None)
        return "bus_voltage", "tip_mach", *known

    def without_limits(self) -> UnlimitedPropulsion:
        """Return these parts without their limits."""
        return UnlimitedPropulsion.model_construct(**dict(self))

    def first_chain(self) -> Propulsion:
        """Return the chain with which the search of the operating point begins."""
        return self.with_links(Propulsion().links)

    def catalogue_values(self) -> list[CatalogueValue]:
        """Return the values of propeller and motor from catalogues, with their sources."""
        propeller_values = catalogue_values(self.propeller, "airframe.propulsion.propeller.")
        if not isinstance(self.motor, str):
            return propeller_values
        motor, prefix = entry_of_key("motor", "motors", self.motor), "airframe.propulsion.motor."
        numbers = {k: v for k, v in motor.numbers().items() if k in Motor.model_fields}
        return propeller_values + [
            CatalogueValue(prefix + key, value, self.motor, motor.label, motor.source_of(key))
            for key, value in numbers.items()
        ]

    def point(
        self,
        thrust_power_w: Value,
        airspeed_m_per_s: Value,
        air: Air,
        bus_voltage_v: Sequence[float] | None,
    ) -> OperatingPoint:
        """Return the operating point of one propulsor in level flight, of the arguments' shape.

        The thrust power [W] is that of the whole aircraft. ``bus_voltage_v``: such as those of the
        empty and the full battery [V]; the point must be feasible at all of them, and the one with
        most bus power is returned.
        """
        power_w, speed, *state = (
            np.asarray(array, float)
            for array in np.broadcast_arrays(thrust_power_w, airspeed_m_per_s, *air)
        )
        assert bus_voltage_v is not None  # refused at validation
        bus_v = np.reshape(bus_voltage_v, (-1,) + (1,) * power_w.ndim)
        # Invalid designs get a placeholder thrust; their efficiencies are masked elsewhere.
        flies = np.isfinite(power_w) & np.isfinite(speed) & (power_w > 0.0) & (speed > 0.0)
        power_w, speed = np.where(flies, power_w, 1.0), np.where(flies, speed, 1.0)
        shaft, thrust_n = self.shaft(power_w, speed, Air(*state)), power_w / speed / self.propulsors
        both = point_behind(self.propulsor, shaft, speed, Air(*state), bus_v, thrust_n)
        weight = np.where(both.reason != "", np.inf, both.bus_power_w)
        worse = np.argmax(weight, axis=0)[np.newaxis]
        point = OperatingPoint(*(np.take_along_axis(row, worse, axis=0)[0] for row in both))
        factor = self.efficiency_factor
        return point._replace(
            propeller_efficiency=point.propeller_efficiency * factor,
            efficiency=point.efficiency * factor,
            bus_power_w=point.bus_power_w / factor,
            bus_current_a=point.bus_current_a / factor,
        )

    def shaft(self, thrust_power_w: Value, airspeed_m_per_s: Value, air: Air) -> Shaft:
        """Return the shaft of one propulsor at a thrust power of the whole aircraft [W]."""
        thrust_n = thrust_power_w / airspeed_m_per_s / self.propulsors
        return shaft_at(self.propulsor.propeller, thrust_n, airspeed_m_per_s, air)

    def bus_power_w(self, shaft: Shaft, bus_v: Value) -> Value:
        """Return the electric power of all propulsors without limits of the parts [W]."""
        power_w = self.propulsor.behind_shaft(shaft, bus_v).bus_w
        return self.propulsors * power_w / self.efficiency_factor

    def shares_of_limits(
        self, shaft: Shaft, airspeed_m_per_s: Value, air: Air, bus_v: Value
    ) -> dict[str, Value]:
        """Return the use of each limit of the parts over that limit [-]."""
        behind = self.propulsor.behind_shaft(shaft, bus_v)
        used = self.propulsor.used_and_limits(shaft, behind, airspeed_m_per_s, air, bus_v)
        return {name: value / most for name, (value, most) in used.items()}

    def in_flight(
        self,
        thrust_power_w: Value,
        airspeed_m_per_s: Value,
        air: Air,
        bus_voltage_v: tuple[float, float] | None,
    ) -> Propulsion:
        """Return the chain of efficiencies at :meth:`point`; NaN where it is infeasible."""
        point = self.point(thrust_power_w, airspeed_m_per_s, air, bus_voltage_v)
        links = {name: getattr(point, f"{link}_efficiency") for name, link in LINKS.items()}
        return self.with_links(links, point.propeller_torque_nm, thrust_power_w / point.efficiency)

    @property
    def estimates_masses(self) -> bool:
        """True if masses missing in the file are estimated: no mass model, no mass per power."""
        named = self.mass_kg_per_w is None and self.mass_model is None
        return named and self.motor_mass_kg is not None

    @cached_property
    def motor_mass_kg(self) -> float | None:
        """Mass of a motor [kg], estimated from its continuous torque if not given; else None."""
        motor = self.motor_constants
        if motor.mass_kg is not None:
            return motor.mass_kg
        torque = part_masses.continuous_torque_nm(motor)
        return part_masses.motor_mass_fit().mass_kg(torque) if torque else None

    @property
    def motor_kg(self) -> Value:
        """Mass of a motor in the mass budget, before its factor [kg]."""
        mass_kg = self.motor_mass_kg if self.estimates_masses else self.motor_constants.mass_kg
        return 0.0 if mass_kg is None else mass_kg

    @property
    def propeller_kg(self) -> Value:
        """Mass of a propeller in the mass budget, before its factor [kg]."""
        choice = self.propeller
        if choice.mass_kg is not None or not self.estimates_masses:
            return 0.0 if choice.mass_kg is None else choice.mass_kg
        diameter_m = choice.propeller.diameter_m if choice.diameter_m is None else choice.diameter_m
        return part_masses.propeller_mass_fit().mass_kg(diameter_m)

    def with_links(
        self, efficiencies: Mapping[str, Any], torque_nm: Value = 0.0, level_w: Value = 1.0
    ) -> ChainOfParts:
        """Return a chain of these parts with efficiencies by the keys of :data:`LINKS`.

        The torque of one propeller [N m] and the electric power of all propulsors [W] in level
        flight give the mass of a gear for which the file has none.
        """
        known_kg = self.controller.mass_kg + (self.gear.mass_kg or 0.0)
        known_kg = known_kg + self.motor_mass_factor * self.motor_kg
        known_kg = known_kg + self.propeller_mass_factor * self.propeller_kg
        gear_kg: Value = 0.0
        if self.estimates_masses and self.gear.mass_kg is None:
            gear_kg = self.propulsors * part_masses.gear_mass_kg(torque_nm, self.gear.ratio)
        default = 0.0 if self.motor_mass_kg is not None else _MASS_KG_PER_W
        links = {f"{name}_efficiency": plain_number(value) for name, value in efficiencies.items()}
        return ChainOfParts.model_construct(
            **links,
            fixed_mass_kg=self.propulsors * known_kg,
            mass_kg_per_w=default if self.mass_kg_per_w is None else self.mass_kg_per_w,
            climb_power_ratio=self.climb_power_ratio,
            climb_rate_m_per_s=self.climb_rate_m_per_s,
            mass_model=self.mass_model,
            gear_kg=plain_number(gear_kg / level_w**_GEAR_BY_POWER),
        )


class UnlimitedPropulsion(OperatingPointPropulsion):
    """Parts whose limits are not checked: a program has them as constraints. Not in files."""

    is_limited = False


def chain_of_numbers(
    parts: OperatingPointPropulsion, efficiency: Value, mass_kg: Value
) -> Propulsion:
    """Return a chain of known efficiency and mass, as one link."""
    return Propulsion.model_construct(
        **_one_link(efficiency),
        fixed_mass_kg=mass_kg,
        mass_kg_per_w=0.0,
        climb_power_ratio=parts.climb_power_ratio,
        climb_rate_m_per_s=parts.climb_rate_m_per_s,
    )


class ChainOfParts(Propulsion):
    """Chain with the efficiencies of parts at their operating point.

    ``gear_kg`` is the mass of gears for which the file has none, over the rated power raised to
    ``_GEAR_BY_POWER`` [kg/W^x]. Not in files.
    """

    gear_kg: Value = Field(default=0.0, exclude=True, repr=False)

    def mass_kg(self, rated_w: Value) -> Value:
        """Return the mass of the propulsion group for a rated electric power [kg]."""
        return super().mass_kg(rated_w) + self.gear_kg * rated_w**_GEAR_BY_POWER

    def mapped(self, function: Callable[[Value], Value]) -> Self:
        """Return the chain with a function applied to its efficiencies and masses."""
        updates = {"gear_kg": function(self.gear_kg)}
        if isinstance(self.fixed_mass_kg, np.ndarray):  # differs between the designs
            updates["fixed_mass_kg"] = function(self.fixed_mass_kg)
        return super().mapped(function).model_copy(update=updates)


# Keys that only parts at their operating point have.
PARTS = OperatingPointPropulsion.model_fields.keys() - Propulsion.model_fields.keys()


def _constant_by_default(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
    """Validate a chain without ``kind`` as constant, without counting the kind as given."""
    if not isinstance(value, Mapping) or "kind" in value:
        return handler(value)
    if PARTS & value.keys():
        part = min(PARTS & value.keys())
        raise wrong_value("kind", f"required key is missing; {part} goes with operating_point")
    chain = handler({"kind": "constant", **value})
    chain.__pydantic_fields_set__.discard("kind")
    return chain


AnyPropulsion = Annotated[
    Propulsion | OperatingPointPropulsion,
    Field(discriminator="kind"),
    WrapValidator(_constant_by_default),
]
