"""Condition of the battery: temperature, internal resistance and age.

The records are optional: without them a battery delivers all of its energy, at the efficiencies of
its file, in any air and at any age. Functions take floats or arrays.

Sources
-------
Ageing: Schmalstieg, Kaebitz, Ecker, Sauer, "A holistic aging model for Li(NiMnCo)O2 based 18650
lithium-ion batteries", Journal of Power Sources 257 (2014) 325-334; cell Sanyo UR18650E, cycled at
1 C and 35 C. Coefficients as in NREL's BLAST-Lite, the lower limit of the resistance's growth as in
REVOL-E-TION, public implementations of the paper.
Capacity over temperature: Samsung SDI, specification of the cell INR18650-15L, section 7.5.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, Strict, model_validator

from missions.air import ZERO_CELSIUS_K
from sizing.smooth import Value
from solar.schema import (
    Fraction,
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Record,
    UnitInterval,
    spell,
)
from solar.types import FloatArray

Celsius = Annotated[float, Strict(), Field(ge=-100.0, le=100.0, allow_inf_nan=False)]
_Offset = Annotated[float, Strict(), Field(ge=-60.0, le=60.0, allow_inf_nan=False)]
_Held = Annotated[float, Strict(), Field(ge=-40.0, le=60.0, allow_inf_nan=False)]
_Voltage = Annotated[float, Strict(), Field(ge=3.2, le=4.2, allow_inf_nan=False)]

REFERENCE_C = 25.0  # of data sheets
_DAYS_PER_MONTH = 365.0 / 12.0
_CELL_AH = 2.05  # nominal capacity of the cell of the ageing law
# Lower bound of capacity and efficiency, for draws of uncertain inputs; far below the law's range.
_LEAST = 0.001
_LARGEST_LOSS = 0.5  # of the voltage: more delivers no further power


class Insulation(Record):
    """Foam around the pack, for its heat loss at any mass.

    ``conductivity_w_per_m_k``: rigid polymer foam, Incropera et al., Fundamentals of Heat and Mass
    Transfer, 6th edition, table A.3 (extruded polystyrene 0.027, moulded 0.040). ``packs`` cubes of
    ``density_kg_per_m3`` hold the battery; thickness and density: assumption.
    """

    thickness_m: PositiveReal = 0.03
    conductivity_w_per_m_k: PositiveReal = 0.03
    packs: PositiveInteger = 1
    density_kg_per_m3: PositiveReal = 2000.0

    def heat_loss_w_per_k(self, mass_kg: Value) -> Value:
        """Return the heat loss of a battery of a mass [W/K].

        Six faces of each cube, ``6 k (m / (n rho))^(2/3) n / d``. Edges and outside air, whose
        effects partly cancel, are neglected.
        """
        face_m2 = (mass_kg / (self.packs * self.density_kg_per_m3)) ** (2.0 / 3.0)
        return 6.0 * self.packs * self.conductivity_w_per_m_k / self.thickness_m * face_m2


class BatteryTemperature(Record):
    """Temperature of the pack by air and heater, and its capacity over temperature.

    The pack is ``ambient_offset_k`` warmer than the air. With ``held_c`` a heater keeps it at least
    at that temperature, limited by ``heater_power_w`` if given. The heater balances the loss to the
    air: ``heat_loss_w_per_k`` times the heater's rise of temperature, or the loss through
    ``insulation``.
    """

    _column_over: ClassVar[Mapping[str, str]] = {"table_capacity_fraction": "table_c"}
    _in_place_of: ClassVar[Mapping[str, str]] = {"insulation": "heat_loss_w_per_k"}

    ambient_offset_k: _Offset = 0.0
    held_c: _Held | None = None
    heat_loss_w_per_k: PositiveReal | None = None
    insulation: Insulation | None = None
    heater_power_w: PositiveReal | None = None
    # Guaranteed at a discharge of 6.7 C by the specification; pessimistic for slow discharge.
    table_c: tuple[Celsius, ...] = Field(default=(-20.0, -10.0, 0.0, 25.0, 60.0), min_length=2)
    table_capacity_fraction: tuple[Fraction, ...] = Field(
        default=(0.60, 0.75, 0.80, 1.0, 1.0), min_length=2
    )

    @model_validator(mode="after")
    def _check_temperature(self) -> BatteryTemperature:
        lost = self.heat_loss_w_per_k is not None or self.insulation is not None
        if (self.held_c is None) == lost:
            raise ValueError("a heater needs held_c and either heat_loss_w_per_k or insulation")
        if self.heater_power_w is not None and self.heat_loss_w_per_k is None:
            raise ValueError("heater_power_w needs held_c and heat_loss_w_per_k")
        return self

    def heated_k(self, air_c: Value) -> Value:
        """Return the rise of temperature by the heater at an air temperature [K]."""
        if self.held_c is None:
            return 0.0 * air_c
        rise_k = np.maximum(self.held_c - (air_c + self.ambient_offset_k), 0.0)
        if self.heater_power_w is None:
            return rise_k
        assert self.heat_loss_w_per_k is not None  # refused at validation
        return np.minimum(rise_k, self.heater_power_w / self.heat_loss_w_per_k)

    def heater_parts_w(self, air_c: Value) -> tuple[Value, Value]:
        """Return the heater's power of known heat loss, and of an insulated pack of 1 kg [W].

        The steady heat loss, ``k (T_held - T_air - offset)``, from 0 to ``heater_power_w``. The
        second scales with ``mass^(2/3)``.
        """
        lost, rise_k = self.heat_loss_w_per_k, self.heated_k(air_c)
        at_1_kg = 0.0 if self.insulation is None else self.insulation.heat_loss_w_per_k(1.0)
        return (0.0 if lost is None else lost) * rise_k, at_1_kg * rise_k

    def pack_c(self, air_c: Value) -> Value:
        """Return the temperature of the pack at an air temperature [C]."""
        return air_c + self.ambient_offset_k + self.heated_k(air_c)

    def capacity_fraction(self, air_c: Value) -> FloatArray:
        """Return the capacity at an air temperature over that at 1 in the table [-]."""
        return np.asarray(np.interp(self.pack_c(air_c), self.table_c, self.table_capacity_fraction))


# Default in thin air: insulation, and a heater to the temperature at which the energy is stated.
HEATED_PACK = BatteryTemperature(held_c=REFERENCE_C, insulation=Insulation())


class Ageing(Record):
    """Calendar and cycle fade of a lithium-ion cell.

    A cycle is a night and a day at ``depth_of_discharge``. ``seasons_flown`` add
    ``cycles_per_season`` cycles and 12 months each to ``cycles`` and ``months``.
    """

    cycles: NonNegativeReal = 0.0
    months: NonNegativeReal = 0.0
    seasons_flown: NonNegativeReal = 0.0
    # A flight a day in the six months around midsummer; assumption.
    cycles_per_season: NonNegativeReal = 180.0
    # The least state of charge was 39 % in AtlantikSolar's 81 h flight of 2015.
    depth_of_discharge: UnitInterval = 0.6
    mean_voltage_v: _Voltage = 3.7
    temperature_c: _Held = REFERENCE_C

    @model_validator(mode="after")
    def _check_ageing(self) -> Ageing:
        if 1.0 - self.calendar_fade() - self.cycle_fade() <= _LEAST:
            cycles, months = spell(self.total_cycles), spell(self.total_months)
            text = f"nothing is left of the battery after {cycles} cycles and {months} months"
            raise ValueError(text)
        return self

    @property
    def total_cycles(self) -> Value:
        """Number of cycles, seasons included."""
        return self.cycles + self.seasons_flown * self.cycles_per_season

    @property
    def total_months(self) -> Value:
        """Age [months], seasons included."""
        return self.months + 12.0 * self.seasons_flown

    @property
    def _days_075(self) -> Value:
        return (self.total_months * _DAYS_PER_MONTH) ** 0.75

    @property
    def _throughput_ah(self) -> Value:
        """Charge and discharge of the law's cell [Ah]."""
        return self.total_cycles * 2.0 * self.depth_of_discharge * _CELL_AH

    def calendar_fade(self) -> Value:
        """Return the loss by age: ``(7.543 V - 23.75) 1e6 exp(-6976/T) t^0.75``, t in days [-]."""
        kelvin = self.temperature_c + ZERO_CELSIUS_K
        rate = (7.543 * self.mean_voltage_v - 23.75) * 1e6 * np.exp(-6976.0 / kelvin)
        return rate * self._days_075

    def cycle_fade(self) -> Value:
        """Return the loss of capacity by cycling [-].

        ``(7.348e-3 (V - 3.667)^2 + 7.6e-4 + 4.081e-3 DOD) Q^0.5``, Q the throughput in Ah of a
        cell of 2.05 Ah.
        """
        rate = (
            7.348e-3 * (self.mean_voltage_v - 3.667) ** 2
            + 7.6e-4
            + 4.081e-3 * self.depth_of_discharge
        )
        return rate * self._throughput_ah**0.5

    def capacity_fraction(self) -> Value:
        """Return the remaining capacity [-]."""
        return np.maximum(1.0 - self.calendar_fade() - self.cycle_fade(), _LEAST)

    def resistance_factor(self) -> Value:
        """Return the internal resistance relative to the new cell [-].

        ``1 + (5.270 V - 16.32) 1e5 exp(-5986/T) t^0.75 + b Q`` with ``b = 2.153e-4 (V - 3.725)^2 -
        1.521e-5 + 2.798e-4 DOD``, at least 1.5e-5.
        """
        kelvin = self.temperature_c + ZERO_CELSIUS_K
        by_age = (5.270 * self.mean_voltage_v - 16.32) * 1e5 * np.exp(-5986.0 / kelvin)
        by_charge = np.maximum(
            2.153e-4 * (self.mean_voltage_v - 3.725) ** 2
            - 1.521e-5
            + 2.798e-4 * self.depth_of_discharge,
            1.5e-5,
        )
        return 1.0 + np.maximum(by_age, 0.0) * self._days_075 + by_charge * self._throughput_ah


class InternalResistance(Record):
    """Efficiencies by the voltage drop at the internal resistance.

    ``loss_at_1c`` is ``R I / V`` at 1 C and 25 C. The efficiencies are those at the mean rates of
    the file, constant over a flight.
    """

    loss_at_1c: Fraction
    discharge_rate_per_h: PositiveReal
    charge_rate_per_h: PositiveReal
    temperature_c: _Held = REFERENCE_C
    # R(T)/R(25 C) = exp(B (1/T - 1/298 K)); B of 21 kJ/mol, ohmic and charge transfer together:
    # assumption.
    activation_k: NonNegativeReal = 2500.0

    @model_validator(mode="after")
    def _check_resistance(self) -> InternalResistance:
        highest = max(self.discharge_rate_per_h, self.charge_rate_per_h)
        lost = float(highest * self.loss_per_rate_h(1.0))
        if lost > _LARGEST_LOSS:
            lost_at = f"loses {round(lost, 2)} of the voltage at {spell(highest)} 1/h"
            raise ValueError(f"{lost_at}: at most {spell(_LARGEST_LOSS)}")
        return self

    def loss_per_rate_h(self, ageing_factor: Value) -> Value:
        """Return the share of the voltage lost per rate, with aged resistance [h]."""
        kelvin = self.temperature_c + ZERO_CELSIUS_K
        colder = 1.0 / kelvin - 1.0 / (REFERENCE_C + ZERO_CELSIUS_K)
        return self.loss_at_1c * np.exp(self.activation_k * colder) * ageing_factor

    def discharge_efficiency(self, ageing_factor: Value) -> Value:
        """Return delivered over drawn energy: ``1 - R I / V`` [-]."""
        lost = self.loss_per_rate_h(ageing_factor) * self.discharge_rate_per_h
        return np.maximum(1.0 - lost, _LEAST)

    def charge_efficiency(self, ageing_factor: Value) -> Value:
        """Return stored over taken energy: ``1 / (1 + R I / V)`` [-]."""
        return 1.0 / (1.0 + self.loss_per_rate_h(ageing_factor) * self.charge_rate_per_h)
