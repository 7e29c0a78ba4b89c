"""Motor, gear, controller, and the voltage that a battery gives them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from sizing.catalogues.entries import MotorEntry
from sizing.catalogues.files import entry
from solar.schema import (
    Fraction,
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Record,
    UnitInterval,
)
from solar.types import FloatArray

__all__ = ["BatteryVoltage", "Controller", "Gear", "Motor", "MotorState"]

_RPM_PER_RAD_PER_S = 30.0 / np.pi


class MotorState(NamedTuple):
    """Current [A] and mean voltage [V] at the motor's terminals."""

    current_a: FloatArray
    voltage_v: FloatArray


class Motor(Record):
    """An electric motor by three constants, or four.

    Drela, M. (2007), First-Order DC Electric Motor Model, MIT Aero & Astro. The fourth is the rise
    of the no-load current with speed of his second-order model: iron and air friction.

    Attributes
    ----------
    speed_constant_rpm_per_v
        Speed over back-EMF [rpm/V].
    resistance_ohm
        Of the windings, from terminal to terminal [ohm].
    no_load_current_a
        At a standstill, with no rise at any speed [A].
    no_load_current_rise_a_per_1000_rpm
        Rise of it with speed [A per 1000 rpm].
    maximum_current_a, maximum_power_w
        Continuous limits of current [A] and power at the terminals [W]; none without them.
    """

    speed_constant_rpm_per_v: PositiveReal
    resistance_ohm: PositiveReal
    no_load_current_a: NonNegativeReal
    no_load_current_rise_a_per_1000_rpm: NonNegativeReal = 0.0
    maximum_current_a: PositiveReal | None = None
    maximum_power_w: PositiveReal | None = None

    @classmethod
    def from_catalogue(cls, name: str) -> Motor:
        """Motor of the catalogue, or of a file with one entry.

        Parameters
        ----------
        name : str
            As ``solar-uav list --motors`` prints it, or the path of a YAML file.

        Returns
        -------
        Motor
        """
        motor = entry("motors", name)
        assert isinstance(motor, MotorEntry)
        return cls(
            speed_constant_rpm_per_v=motor.speed_constant_rpm_per_v,
            resistance_ohm=motor.resistance_ohm,
            no_load_current_a=motor.no_load_current_a,
            maximum_current_a=motor.maximum_current_a,
        )

    def state(self, speed_rpm: ArrayLike, torque_nm: ArrayLike) -> MotorState:
        """Current and voltage at a speed and a torque.

        ``i = Q K_v + i_0(Omega)`` and ``v = Omega / K_v + i R``, with ``K_v`` in rad/s per volt.

        Parameters
        ----------
        speed_rpm, torque_nm : array_like
            Speed [rpm] and torque at the shaft [N m].

        Returns
        -------
        MotorState
            Of the broadcast shape of the arguments.
        """
        rpm = np.asarray(speed_rpm, float)
        constant = self.speed_constant_rpm_per_v / _RPM_PER_RAD_PER_S
        rise = self.no_load_current_rise_a_per_1000_rpm * rpm / 1000.0
        current = np.asarray(torque_nm, float) * constant + self.no_load_current_a + rise
        return MotorState(
            current, rpm / self.speed_constant_rpm_per_v + current * self.resistance_ohm
        )


class Gear(Record):
    """A reduction gear, or none.

    Attributes
    ----------
    ratio
        Speed of the motor over that of the propeller [-].
    efficiency
        Power out over power in [-].
    """

    ratio: PositiveReal = 1.0
    efficiency: Fraction = 1.0


class Controller(Record):
    """A controller that chops the bus voltage down to the motor's.

    A step-down converter with a continuous current (Mohan, Undeland & Robbins, Power Electronics,
    chapters 2 and 7): of the current's path a resistance, for the share of the time that the bus is
    off a diode, and at every change of the switches a loss in proportion to voltage and current.

    Attributes
    ----------
    resistance_ohm
        Of the switches that the motor's current passes [ohm].
    freewheel_voltage_v
        Of the diode [V]: about 0.7 for silicon, 0 where a switch bridges it.
    switching_loss
        ``(t_on + t_off) f / 2``: duration of the changes times their frequency [-].
    idle_power_w
        Of its electronics [W].
    """

    resistance_ohm: NonNegativeReal
    freewheel_voltage_v: NonNegativeReal = 0.0
    switching_loss: UnitInterval = 0.0
    idle_power_w: NonNegativeReal = 0.0

    def input_power_w(self, motor: MotorState, voltage_v: FloatArray) -> FloatArray:
        """Power at the input at a voltage there.

        ``P = i v + i^2 R + (1 - d) i V_f + s V i + P_0``.

        Parameters
        ----------
        motor : MotorState
            Current and voltage at the motor.
        voltage_v : ndarray
            Voltage at the input [V].

        Returns
        -------
        ndarray
            Power [W].
        """
        current = motor.current_a
        resistive = current * (motor.voltage_v + current * self.resistance_ohm)
        freewheeling = (1.0 - self.duty(motor, voltage_v)) * current * self.freewheel_voltage_v
        switching = self.switching_loss * voltage_v * current
        return np.asarray(resistive + freewheeling + switching + self.idle_power_w)

    def duty(self, motor: MotorState, voltage_v: FloatArray) -> FloatArray:
        """Share of the time that the bus is on: ``d V - (1 - d) V_f = v + i R``.

        Parameters
        ----------
        motor : MotorState
            Current and voltage at the motor.
        voltage_v : ndarray
            Voltage at the input [V].

        Returns
        -------
        ndarray
            Duty [-]; above 1 where the voltage does not suffice.
        """
        needed = motor.voltage_v + motor.current_a * self.resistance_ohm
        diode = self.freewheel_voltage_v
        return np.asarray((needed + diode) / (voltage_v + diode))


class BatteryVoltage(Record):
    """Voltage of a battery over its state of charge.

    Attributes
    ----------
    cells_in_series
        Number of cells in series.
    state_of_charge, cell_voltage_v
        Voltage of a cell [V], at the currents of the flight, over states of charge from 0 to 1.
    """

    cells_in_series: PositiveInteger
    state_of_charge: tuple[UnitInterval, ...] = Field(min_length=2)
    cell_voltage_v: tuple[PositiveReal, ...] = Field(min_length=2)

    @model_validator(mode="after")
    def _check_table(self) -> BatteryVoltage:
        wrong = ""
        if len(self.state_of_charge) != len(self.cell_voltage_v):
            wrong = "cell_voltage_v must have a value for each state of charge"
        elif np.any(np.diff(self.state_of_charge) <= 0.0):
            wrong = "state_of_charge must increase strictly"
        elif np.any(np.diff(self.cell_voltage_v) < 0.0):
            wrong = "cell_voltage_v must not fall with the state of charge"
        if wrong:
            raise PydanticCustomError("voltage_table", "{wrong}", {"wrong": wrong})
        return self

    def voltage_v(self, state_of_charge: ArrayLike) -> FloatArray:
        """Voltage of the battery.

        Parameters
        ----------
        state_of_charge : array_like
            Within the table [-].

        Returns
        -------
        ndarray
            Voltage [V].

        Raises
        ------
        ValueError
            Outside the table.
        """
        charge = np.asarray(state_of_charge, float)
        first, last = self.state_of_charge[0], self.state_of_charge[-1]
        odd = charge[~((charge >= first) & (charge <= last))]
        if odd.size:
            raise ValueError(
                f"state_of_charge must be from {first:g} to {last:g}, where the table of voltages "
                f"ends (got {odd.flat[0]:g})"
            )
        cell = np.interp(charge, self.state_of_charge, self.cell_voltage_v)
        return np.asarray(self.cells_in_series * cell)
