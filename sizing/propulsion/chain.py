"""The propulsion of an aircraft's file: a chain of constants, or parts at their operating point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import cached_property
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
from sizing.catalogues.choice import Kind, OfCatalogue, Taken, found_entry, taken
from sizing.own_models import propulsion_efficiency_function, propulsion_mass_function
from sizing.parameters import all_replaced, replaced
from sizing.propulsion.electric import Controller, Gear, Motor
from sizing.propulsion.operating_point import (
    OperatingPoint,
    Propulsor,
    bus_power_w,
    operating_point,
    propeller_state,
)
from sizing.propulsion.part_masses import (
    GEAR_EXPONENT,
    continuous_torque_nm,
    gear_mass_kg,
    motor_mass_fit,
    propeller_mass_fit,
)
from sizing.propulsion.propeller_choice import PropellerChoice
from sizing.smooth import Value
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
# Rated over level-flight power where a file says nothing: AtlantikSolar has 180 W over 35.8 W.
_CLIMB_POWER_RATIO = 5.0
_MASS_KG_PER_W = 0.0011
# Of a propeller at one advance ratio power goes with the cube of its speed, torque with the square.
_GEAR_BY_POWER = GEAR_EXPONENT * 2.0 / 3.0
# Links from the bus to the air, and those of an operating point that they stand for.
LINKS = {
    "wiring": "wiring",
    "controller": "controller",
    "motor": "motor",
    "gearbox": "gear",
    "propeller": "propeller",
}

_MassModel = Annotated[Text, AfterValidator(lambda name: propulsion_mass_function(name) and name)]
_EfficiencyModel = Annotated[
    Text, AfterValidator(lambda name: propulsion_efficiency_function(name) and name)
]
_ClimbRatio = Annotated[float, Strict(), Field(ge=1.0)]


class Propulsion(OfCatalogue):
    """Propulsion chain from the battery bus to thrust power, and its mass.

    The group's mass follows its rated electric power: level flight's times ``climb_power_ratio``
    (5 by default), or what climbing at ``climb_rate_m_per_s`` takes at the airspeed of level
    flight, ``P_level + m g v_climb / efficiency``. One of the two, not both. ``fixed_mass_kg`` is
    what does not follow the power.

    ``motor`` names an entry of the catalogue of motors, which gives the motor's best efficiency at
    ``motor_voltage_v``. ``mass_model`` names a model of the user's own for the mass, instead of
    ``mass_kg_per_w``: see :func:`sizing.register_propulsion_mass`. ``efficiency_model`` names one
    for the efficiency of the whole chain, instead of those of its links: see
    :func:`sizing.register_propulsion_efficiency`.
    """

    _entries: ClassVar[Mapping[str, Kind]] = {"motor": "motors"}

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

    @model_validator(mode="after")
    def _check_rating(self) -> Propulsion:
        _check_one_rating(self)
        return self

    def in_level_flight(
        self, power_w: Value, airspeed_m_per_s: Value, density_kg_per_m3: Value
    ) -> Propulsion:
        """Chain whose efficiency is that of the user's own model, as one link; else itself.

        ``power_w``: drag times airspeed.
        """
        if self.efficiency_model is None:
            return self
        own = propulsion_efficiency_function(self.efficiency_model)
        one_link: dict[str, Any] = {f"{name}_efficiency": 1.0 for name in LINKS}
        one_link["propeller_efficiency"] = own(power_w, airspeed_m_per_s, density_kg_per_m3)
        return self.model_copy(update=one_link | {"efficiency_model": None})

    def rated_power_w(self, level_w: Value, *, weight_n: Value) -> Value:
        """Rated electric power [W].

        Returns ``level_w + weight_n v_climb / efficiency`` where a climb rate is given, else the
        climb power ratio times ``level_w`` [W].
        """
        if self.climb_rate_m_per_s is not None:
            return level_w + weight_n * self.climb_rate_m_per_s / self.efficiency
        ratio = self.climb_power_ratio
        return (_CLIMB_POWER_RATIO if ratio is None else ratio) * level_w

    def mass_kg(self, rated_w: Value) -> Value:
        """Mass of the propulsion group for its rated electric power [kg]."""
        if self.mass_model is not None:
            mass_kg = propulsion_mass_function(self.mass_model)(rated_w)
        else:
            mass_kg = self.mass_kg_per_w * rated_w
        return mass_kg if self.fixed_mass_kg is None else self.fixed_mass_kg + mass_kg

    @property
    def links(self) -> dict[str, Value]:
        """Efficiency of each of :data:`LINKS` [-]; 1 of one that the chain does not have."""
        named = {name: getattr(self, f"{name}_efficiency") for name in LINKS}
        return {name: 1.0 if one is None else one for name, one in named.items()}

    def mapped(self, function: Callable[[Value], Value]) -> Self:
        """Chain with a function of what differs between designs."""
        links = {f"{name}_efficiency": function(one) for name, one in self.links.items()}
        return self.model_copy(update=links)

    @property
    def efficiency(self) -> float:
        """Efficiency of the whole chain [-]."""
        chain = (
            self.controller_efficiency
            * self.motor_efficiency
            * self.gearbox_efficiency
            * self.propeller_efficiency
        )
        return chain if self.wiring_efficiency is None else self.wiring_efficiency * chain


class OperatingPointPropulsion(Record):
    """Propellers, gears, motors and controllers whose efficiencies follow from level flight.

    ``propulsors`` of one kind share the thrust. ``motor`` is the name of an entry of the catalogue,
    the path of one's own, or the constants themselves. Masses are those of one propulsor's parts;
    ``mass_kg_per_w`` comes on top, and is 0 where the motor's mass is known. ``efficiency_factor``
    is what the propellers have over what is computed; ``motor_mass_factor`` and
    ``propeller_mass_factor`` what those parts weigh over what is given or estimated.
    """

    # Whether a batch of designs is too dear to have its operating points at every step.
    is_exact: ClassVar[bool] = True
    # Whether the limits of its parts refuse a flight.
    is_limited: ClassVar[bool] = True

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
    def _check_parts(self) -> OperatingPointPropulsion:
        _check_one_rating(self)
        if isinstance(self.motor, str):
            found_entry("motor", "motors", self.motor)
        return self

    def sized(
        self,
        diameter_m: Value | None,
        pitch_m: Value | None,
        gear_ratio: Value | None,
        speed_constant_rpm_per_v: Value | None = None,
    ) -> Self:
        """These parts with a chosen diameter and pitch [m], gear and winding of the motor.

        None leaves the file's. A motor that is wound anew has the mass that it had.
        """
        sizes: dict[str, Any] = {
            "propeller.diameter_m": diameter_m,
            "propeller.pitch_m": pitch_m,
            "gear.ratio": gear_ratio,
        }
        if diameter_m is not None and self.propeller.mass_kg:
            # The file's mass is that of the file's diameter.
            larger = diameter_m / self.propeller.diameter_m
            grown = larger ** propeller_mass_fit().exponent
            sizes["propeller.mass_kg"] = self.propeller.mass_kg * grown
        if speed_constant_rpm_per_v is not None:
            wound = self.own_motor.rewound(speed_constant_rpm_per_v)
            sizes["motor"] = replaced(wound, ["mass_kg"], self.motor_mass_kg)
        chosen: dict[str, Any] = {k: value for k, value in sizes.items() if value is not None}
        if diameter_m is not None or pitch_m is not None:
            chosen["propeller.product"] = None  # of that size it is no longer
        return all_replaced(self, chosen) if chosen else self

    @cached_property
    def own_motor(self) -> Motor:
        """Motor of the file, or of the catalogue."""
        return Motor.from_catalogue(self.motor) if isinstance(self.motor, str) else self.motor

    @cached_property
    def propulsor(self) -> Propulsor:
        """One of the propulsors."""
        return Propulsor(
            propeller=self.propeller.propeller,
            motor=self.own_motor,
            controller=self.controller,
            gear=self.gear,
            wiring_resistance_ohm=self.wiring_resistance_ohm,
            maximum_tip_mach=self.maximum_tip_mach,
            limited=self.is_limited,
        )

    def taken(self) -> list[Taken]:
        """Values of propeller and motor that the catalogues give, with their sources."""
        of_propeller = taken(self.propeller, "airframe.propulsion.propeller.")
        if not isinstance(self.motor, str):
            return of_propeller
        one = found_entry("motor", "motors", self.motor)
        return of_propeller + [
            Taken(
                f"airframe.propulsion.motor.{key}", value, self.motor, one.label, one.source_of(key)
            )
            for key, value in one.numbers().items()
            if key in Motor.model_fields
        ]

    def point(
        self,
        thrust_power_w: Value,
        airspeed_m_per_s: Value,
        air: Air,
        bus_voltage_v: tuple[float, float],
    ) -> OperatingPoint:
        """Operating point of one propulsor in level flight.

        ``thrust_power_w``, ``airspeed_m_per_s``, ``air``: of the whole aircraft; numbers or arrays.
        ``bus_voltage_v``: of the empty and of the full battery [V]. It must work at both; of the
        two, the one that takes more power counts. Returns of the arguments' shape.
        """
        power_w, speed, *state = (
            np.asarray(one, float)
            for one in np.broadcast_arrays(thrust_power_w, airspeed_m_per_s, *air)
        )
        bus_v = np.reshape(bus_voltage_v, (2,) + (1,) * power_w.ndim)
        # A design that carries nothing has no thrust; it is masked with its efficiencies.
        flies = np.isfinite(power_w) & np.isfinite(speed) & (power_w > 0.0) & (speed > 0.0)
        power_w, speed = np.where(flies, power_w, 1.0), np.where(flies, speed, 1.0)
        thrust_n = power_w / speed / self.propulsors
        both = operating_point(self.propulsor, thrust_n, speed, Air(*state), bus_v)
        weight = np.where(both.reason != "", np.inf, both.bus_power_w)
        worse = np.argmax(weight, axis=0)[np.newaxis]
        point = OperatingPoint(
            *(
                np.take_along_axis(getattr(both, one.name), worse, axis=0)[0]
                for one in fields(OperatingPoint)
            )
        )
        factor = self.efficiency_factor  # the propeller is as much better than computed
        if factor == 1.0:
            return point
        return replace(
            point,
            propeller_efficiency=point.propeller_efficiency * factor,
            efficiency=point.efficiency * factor,
            bus_power_w=point.bus_power_w / factor,
            bus_current_a=point.bus_current_a / factor,
        )

    def bus_power_w(
        self, thrust_power_w: Value, airspeed_m_per_s: Value, air: Air, bus_v: Value
    ) -> Value:
        """Electric power of all propulsors, whatever the limits of their parts are [W].

        Voltages broadcast with the others. NaN where the propeller's data end.
        """
        thrust_n = thrust_power_w / airspeed_m_per_s / self.propulsors
        power_w = bus_power_w(self.propulsor, thrust_n, airspeed_m_per_s, air, bus_v)
        return self.propulsors * power_w / self.efficiency_factor

    def propeller_state(
        self, thrust_power_w: Value, airspeed_m_per_s: Value, air: Air
    ) -> tuple[Value, Value, Value]:
        """Speed of rotation [1/s], power at one shaft [W] and power over thrust power [-].

        NaN where the propeller's data end.
        """
        thrust_w = thrust_power_w / self.propulsors
        turns, shaft_w = propeller_state(
            self.propulsor, thrust_w / airspeed_m_per_s, airspeed_m_per_s, air
        )
        return turns, shaft_w, shaft_w / thrust_w

    def in_flight(
        self,
        thrust_power_w: Value,
        airspeed_m_per_s: Value,
        air: Air,
        bus_voltage_v: tuple[float, float],
    ) -> Propulsion:
        """Chain of constants at an operating point, see :meth:`point`; NaN where there is none."""
        point = self.point(thrust_power_w, airspeed_m_per_s, air, bus_voltage_v)
        links = {name: getattr(point, f"{link}_efficiency") for name, link in LINKS.items()}
        return self.with_links(links, point.propeller_torque_nm, thrust_power_w / point.efficiency)

    @property
    def estimates_masses(self) -> bool:
        """Whether parts without a mass have one by relations: unless the file says how all grow."""
        named = self.mass_kg_per_w is None and self.mass_model is None
        return named and self.motor_mass_kg is not None

    @cached_property
    def motor_mass_kg(self) -> float | None:
        """Mass of a motor [kg], by its continuous torque where it is not known, else None."""
        motor = self.own_motor
        if motor.mass_kg is not None:
            return motor.mass_kg
        torque = continuous_torque_nm(motor)
        return motor_mass_fit().mass_kg(torque) if torque else None

    @property
    def motor_kg(self) -> Value:
        """Mass of a motor that the budget has [kg], without its factor."""
        mass_kg = self.motor_mass_kg if self.estimates_masses else self.own_motor.mass_kg
        return 0.0 if mass_kg is None else mass_kg

    @property
    def propeller_kg(self) -> Value:
        """Mass of a propeller that the budget has [kg], without its factor."""
        own = self.propeller
        if own.mass_kg is not None or not self.estimates_masses:
            return 0.0 if own.mass_kg is None else own.mass_kg
        diameter_m = own.propeller.diameter_m if own.diameter_m is None else own.diameter_m
        return propeller_mass_fit().mass_kg(diameter_m)

    def with_links(
        self, efficiencies: Mapping[str, Any], torque_nm: Value = 0.0, level_w: Value = 1.0
    ) -> ChainOfParts:
        """Chain of constants of these parts; efficiencies by :data:`LINKS`, of floats or arrays.

        ``torque_nm``, ``level_w``: of one propeller in level flight [N m] and electric power of
        all [W], by which a gear without a mass has one.
        """
        known_kg = self.controller.mass_kg + (self.gear.mass_kg or 0.0)
        known_kg = known_kg + self.motor_mass_factor * self.motor_kg
        known_kg = known_kg + self.propeller_mass_factor * self.propeller_kg
        gear_kg: Value = 0.0
        if self.estimates_masses and self.gear.mass_kg is None:
            gear_kg = self.propulsors * gear_mass_kg(torque_nm, self.gear.ratio)
        default = 0.0 if self.motor_mass_kg is not None else _MASS_KG_PER_W
        links = {f"{name}_efficiency": plain_number(one) for name, one in efficiencies.items()}
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
    """Parts that fly beyond their limits: those are rows of a program. No file has it."""

    is_limited = False

    @classmethod
    def of(cls, parts: OperatingPointPropulsion) -> UnlimitedPropulsion:
        """These parts without their limits."""
        fields = {name: getattr(parts, name) for name in OperatingPointPropulsion.model_fields}
        return cls.model_construct(**fields)


def chain_of_numbers(
    parts: OperatingPointPropulsion, efficiency: Value, mass_kg: Value
) -> Propulsion:
    """Chain of parts of which efficiency and mass are known, as one link."""
    links: dict[str, Any] = {f"{name}_efficiency": 1.0 for name in LINKS}
    return Propulsion.model_construct(
        **links | {"propeller_efficiency": efficiency},
        fixed_mass_kg=mass_kg,
        mass_kg_per_w=0.0,
        climb_power_ratio=parts.climb_power_ratio,
        climb_rate_m_per_s=parts.climb_rate_m_per_s,
    )


class ChainOfParts(Propulsion):
    """Efficiencies of parts at their operating point.

    ``gear_kg``: mass of gears without a mass in the file, over the rated power to the power by
    which their torque grows with it. No file has this key.
    """

    gear_kg: Value = Field(default=0.0, exclude=True, repr=False)

    def mass_kg(self, rated_w: Value) -> Value:
        """Mass of the propulsion group for its rated electric power [kg]."""
        return super().mass_kg(rated_w) + self.gear_kg * rated_w**_GEAR_BY_POWER

    def mapped(self, function: Callable[[Value], Value]) -> Self:
        """Chain with a function of what differs between designs, gears included."""
        own = {"gear_kg": function(self.gear_kg)}
        if isinstance(self.fixed_mass_kg, np.ndarray):  # of sizes of their own
            own["fixed_mass_kg"] = function(self.fixed_mass_kg)
        return super().mapped(function).model_copy(update=own)


def _check_one_rating(chain: Propulsion | OperatingPointPropulsion) -> None:
    """Refuse a propulsion that is rated twice."""
    if chain.climb_power_ratio is not None and chain.climb_rate_m_per_s is not None:
        raise wrong_value(
            "climb_rate_m_per_s",
            "is an alternative to climb_power_ratio: give one of them, null for the other "
            f"(got {chain.climb_rate_m_per_s:g} and a ratio of {chain.climb_power_ratio:g})",
        )


# Keys that an operating point alone has.
PARTS = OperatingPointPropulsion.model_fields.keys() - Propulsion.model_fields.keys()


def _constant_by_default(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
    """Chains without a kind are constant; that kind does not count as given."""
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
