"""Voltage that a battery gives the bus."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from solar.schema import CellCount, PositiveReal, Record, UnitInterval
from solar.types import FloatArray


class BatteryVoltage(Record):
    """Voltage of a battery over its state of charge.

    Attributes
    ----------
    cells_in_series
        Number of cells in series.
    state_of_charge, cell_voltage_v
        Voltage of a cell [V], at the currents of the flight, over states of charge from 0 to 1.
    """

    cells_in_series: CellCount
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
            raise ValueError(wrong)
        return self

    @property
    def ends_v(self) -> tuple[float, float]:
        """Voltages of the battery where the table begins and ends: empty and full [V]."""
        low, high = self.voltage_v([self.state_of_charge[0], self.state_of_charge[-1]])
        return float(low), float(high)

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
