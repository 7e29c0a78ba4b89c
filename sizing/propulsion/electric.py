"""Models of motor, gear and controller."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydantic import model_validator

from sizing.catalogues.choice import entry
from sizing.parameters import all_replaced
from sizing.smooth import Value
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Record, UnitInterval, wrong_value
from solar.types import FloatArray

_RPM_PER_RAD_PER_S = 30.0 / np.pi


def _check_efficiency(
    part: Motor | Controller, needed: tuple[str, ...], others: tuple[str, ...] = ()
) -> None:
    """Check that a part has either an efficiency or the losses it needs."""
    keys = part.model_fields_set
    for key in needed if part.efficiency is None else ():
        if key not in keys:
            raise wrong_value(key, "required key is missing (or efficiency, one for all loads)")
    for key in (*needed, *others) if part.efficiency is not None else ():
        if key in keys:
            raise wrong_value(key, "give this or efficiency, not both", got=getattr(part, key))


class MotorState(NamedTuple):
    """Current [A] and mean voltage [V] at the motor's terminals."""

    current_a: FloatArray
    voltage_v: FloatArray


class Motor(Record):
    """Electric motor by three or four constants, or by speed constant and efficiency.

    Drela, M. (2007), First-Order DC Electric Motor Model, MIT Aero & Astro. The fourth constant is
    the rise of the no-load current with speed in his second-order model: iron and air friction.

    Attributes
    ----------
    speed_constant_rpm_per_v
        Speed over back-EMF [rpm/V].
    resistance_ohm
        Of the windings, from terminal to terminal [ohm].
    no_load_current_a
        At a standstill, with no rise at any speed [A].
    efficiency
        The same at every load, in place of resistance and no-load current [-].
    no_load_current_rise_a_per_1000_rpm
        Rise of the no-load current with speed [A per 1000 rpm].
    maximum_current_a, maximum_power_w
        Continuous limits of current [A] and power at the terminals [W]; none without them.
    mass_kg
        Mass [kg]; None if unknown.
    """

    speed_constant_rpm_per_v: PositiveReal
    resistance_ohm: NonNegativeReal = 0.0
    no_load_current_a: NonNegativeReal = 0.0
    efficiency: Fraction | None = None
    no_load_current_rise_a_per_1000_rpm: NonNegativeReal = 0.0
    maximum_current_a: PositiveReal | None = None
    maximum_power_w: PositiveReal | None = None
    mass_kg: NonNegativeReal | None = None

    @model_validator(mode="after")
    def _check_losses(self) -> Motor:
        _check_efficiency(self, ("resistance_ohm", "no_load_current_a"))
        if self.efficiency is None and self.resistance_ohm == 0.0:
            raise wrong_value("resistance_ohm", "must be a number greater than 0", got=0)
        return self

    @classmethod
    def from_catalogue(cls, name: str) -> Motor:
        """Return the motor of a catalogue entry, by its name or the path of a YAML file."""
        motor = entry("motors", name)
        keys = cls.model_fields.keys() & type(motor).model_fields.keys()
        return cls(**{key: getattr(motor, key) for key in keys})

    def rewound(self, speed_constant_rpm_per_v: Value) -> Motor:
        """Return the motor with another number of turns, for another speed constant.

        ``N`` turns in the same slots have ``K_v ~ 1/N`` and, of wire with ``1/N`` of the section,
        ``R ~ N^2``: with ``k`` the ratio of the speed constants ``R/k^2``, and currents times ``k``
        for the same torque and field in iron and air gap. So torque, losses and best efficiency at
        a speed stay, as do mass and limit of power, and the voltage goes with ``1/k``: the motor
        constant ``K_t / sqrt(R)`` is independent of the winding (Wikipedia, Motor constants). The
        speed constant may be a number, an array or a symbol [rpm/V]; the motor is not validated.
        """
        ratio = speed_constant_rpm_per_v / self.speed_constant_rpm_per_v
        most_a = self.maximum_current_a
        constants = {
            "speed_constant_rpm_per_v": speed_constant_rpm_per_v,
            "resistance_ohm": self.resistance_ohm / ratio**2,
            "no_load_current_a": ratio * self.no_load_current_a,
            "no_load_current_rise_a_per_1000_rpm": ratio * self.no_load_current_rise_a_per_1000_rpm,
            "maximum_current_a": None if most_a is None else ratio * most_a,
        }
        return all_replaced(self, constants)

    def state(self, rpm: Value, torque_nm: Value) -> MotorState:
        """Return current and voltage at a speed and a torque.

        ``i = Q K_v + i_0(Omega)`` and ``v = Omega / K_v + i R``, with ``K_v`` in rad/s per volt.

        Parameters
        ----------
        rpm, torque_nm
            Speed [rpm] and torque at the shaft [N m]: numbers, arrays or symbols.

        Returns
        -------
        MotorState
        """
        constant = self.speed_constant_rpm_per_v / _RPM_PER_RAD_PER_S
        rise = self.no_load_current_rise_a_per_1000_rpm * rpm / 1000.0
        current = torque_nm * constant + self.no_load_current_a + rise
        if self.efficiency is not None:
            current = current / self.efficiency
        return MotorState(
            current, rpm / self.speed_constant_rpm_per_v + current * self.resistance_ohm
        )


class Gear(Record):
    """Reduction gear; ratio 1 for none.

    Attributes
    ----------
    ratio
        Speed of the motor over that of the propeller [-].
    efficiency
        Power out over power in [-].
    mass_kg
        Mass [kg]; None estimates it by
        :func:`sizing.propulsion.part_masses.gear_mass_kg` in an aircraft.
    """

    ratio: PositiveReal = 1.0
    efficiency: Fraction = 1.0
    mass_kg: NonNegativeReal | None = None


class Controller(Record):
    """Motor controller that chops the bus voltage; by its losses or by one efficiency.

    A step-down converter with a continuous current (Mohan, Undeland & Robbins, Power Electronics,
    chapters 2 and 7): of the current's path a resistance, for the share of the time that the bus is
    off a diode, and at every change of the switches a loss in proportion to voltage and current.

    Attributes
    ----------
    efficiency
        The same at every load, in place of all losses [-].
    resistance_ohm
        Of the switches that the motor's current passes [ohm].
    freewheel_voltage_v
        Of the diode [V]: about 0.7 for silicon, 0 where a switch bridges it.
    switching_loss
        ``(t_on + t_off) f / 2``: duration of the changes times their frequency [-].
    idle_power_w
        Of its electronics [W].
    mass_kg
        Mass [kg].
    """

    efficiency: Fraction | None = None
    resistance_ohm: NonNegativeReal = 0.0
    freewheel_voltage_v: NonNegativeReal = 0.0
    switching_loss: UnitInterval = 0.0
    idle_power_w: NonNegativeReal = 0.0
    mass_kg: NonNegativeReal = 0.0

    @model_validator(mode="after")
    def _check_losses(self) -> Controller:
        _check_efficiency(
            self, ("resistance_ohm",), ("freewheel_voltage_v", "switching_loss", "idle_power_w")
        )
        return self

    def input_power_w(self, motor: MotorState, voltage_v: Value) -> Value:
        """Return the input power at an input voltage.

        ``P = i v + i^2 R + (1 - d) i V_f + s V i + P_0``, or ``i v`` over the efficiency.

        Parameters
        ----------
        motor : MotorState
            Current and voltage at the motor: numbers, arrays or symbols.
        voltage_v
            Voltage at the input [V].

        Returns
        -------
        Value
            Power [W].
        """
        current = motor.current_a
        if self.efficiency is not None:
            return current * motor.voltage_v / self.efficiency
        resistive = current * (motor.voltage_v + current * self.resistance_ohm)
        idle_share = 1.0 - self.duty(motor, voltage_v)
        freewheeling = idle_share * current * self.freewheel_voltage_v
        switching = self.switching_loss * voltage_v * current
        return resistive + freewheeling + switching + self.idle_power_w

    def duty(self, motor: MotorState, voltage_v: Value) -> Value:
        """Return the share of the time that the bus is on: ``d V - (1 - d) V_f = v + i R``.

        Parameters
        ----------
        motor : MotorState
            Current and voltage at the motor: numbers, arrays or symbols.
        voltage_v
            Voltage at the input [V].

        Returns
        -------
        Value
            Duty [-]; above 1 where the voltage does not suffice.
        """
        needed = motor.voltage_v + motor.current_a * self.resistance_ohm
        diode = self.freewheel_voltage_v
        return (needed + diode) / (voltage_v + diode)
