"""Battery: energy, efficiencies, charge limit, voltage, temperature and age."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, ModelWrapValidatorHandler, Strict, model_validator

from missions.air import thin_air_share
from sizing.battery.condition import HEATED_PACK, Ageing, BatteryTemperature, InternalResistance
from sizing.battery.pack import BatteryPack, with_pack_values
from sizing.catalogues.choice import CatalogueRecord, Kind, known_entry
from sizing.smooth import Value
from solar.schema import (
    Allowed,
    CellCount,
    Fraction,
    PositiveReal,
    Record,
    Text,
    UnitInterval,
    wrong_value,
)
from solar.types import FloatArray

# Upper bound of chemistry: Gibbs energy of formation of BeO, 580.1 kJ/mol over 25.012 g/mol (CRC
# Handbook of Chemistry and Physics). Lithium and fluorine give 6293 Wh/kg.
_HIGHEST_WH_PER_KG = 6443.0


class NoChargeLimit(Record):
    """Absent charge limit: the battery takes all excess solar power."""

    kind: Literal["none"] = "none"


class RuleChargeLimit(Record):
    """Constant current, then an exponential taper up to full charge.

    The design rule of AtlantikSolar without measurements: 0.5 C up to 90 % state of charge, falling
    exponentially to 4.6 % of that at full charge.
    """

    kind: Literal["rule"] = "rule"
    c_rate_per_h: PositiveReal = 0.5
    taper_start: Annotated[float, Strict(), Field(ge=0.0, lt=1.0)] = 0.9
    relative_rate_at_full: Fraction = 0.046


class TableChargeLimit(Record):
    """Charge current measured over the state of charge; constant outside the table."""

    _column_over: ClassVar[Mapping[str, str]] = {"current_a": "state_of_charge"}

    kind: Literal["table"] = "table"
    state_of_charge: tuple[UnitInterval, ...] = Field(min_length=2)
    current_a: tuple[PositiveReal, ...] = Field(min_length=2)
    voltage_v: PositiveReal
    pack_energy_wh: PositiveReal

    @model_validator(mode="after")
    def _check_limits(self) -> TableChargeLimit:
        if np.any(np.diff(self.current_a) > 0.0):
            raise ValueError("current_a must not rise with the state of charge")
        return self


ChargeLimit = Annotated[
    NoChargeLimit | RuleChargeLimit | TableChargeLimit, Field(discriminator="kind")
]


def constant_up_to(limit: ChargeLimit) -> float:
    """Return the state of charge up to which a charge limit is constant [-]."""
    if isinstance(limit, RuleChargeLimit):
        return limit.taper_start
    return limit.state_of_charge[0] if isinstance(limit, TableChargeLimit) else 1.0


def charge_rate_per_h(limit: ChargeLimit, state_of_charge: ArrayLike) -> FloatArray:
    """Return the largest stored power relative to the energy at full charge [1/h].

    A table is constant outside its range. :class:`NoChargeLimit`, which has no finite rate, raises
    ValueError.
    """
    soc = np.asarray(state_of_charge, float)
    if isinstance(limit, RuleChargeLimit):
        decay = -np.log(limit.relative_rate_at_full) / (1.0 - limit.taper_start)
        beyond = np.maximum(soc - limit.taper_start, 0.0)
        return np.asarray(limit.c_rate_per_h * np.exp(-decay * beyond))
    if isinstance(limit, TableChargeLimit):
        power_w = np.asarray(limit.current_a) * limit.voltage_v
        return np.asarray(np.interp(soc, limit.state_of_charge, power_w / limit.pack_energy_wh))
    raise ValueError("a battery without charge limit has no finite charge rate")


class BatteryVoltage(Record):
    """Voltage of a battery over its state of charge.

    Attributes
    ----------
    cells_in_series
        Number of cells in series.
    state_of_charge, cell_voltage_v
        Voltage of a cell [V], at the currents of the flight, over states of charge from 0 to 1.
    """

    _column_over: ClassVar[Mapping[str, str]] = {"cell_voltage_v": "state_of_charge"}

    cells_in_series: CellCount
    state_of_charge: tuple[UnitInterval, ...] = Field(min_length=2)
    cell_voltage_v: tuple[PositiveReal, ...] = Field(min_length=2)

    @model_validator(mode="after")
    def _check_table(self) -> BatteryVoltage:
        if np.any(np.diff(self.cell_voltage_v) < 0.0):
            raise ValueError("cell_voltage_v must not fall with the state of charge")
        return self

    def voltage_v(self, state_of_charge: ArrayLike) -> FloatArray:
        """Return the voltage of the battery [V]; ValueError outside the table."""
        charge = np.asarray(state_of_charge, float)
        table = Allowed(self.state_of_charge[0], self.state_of_charge[-1])
        table.check("state_of_charge", charge)
        cell = np.interp(charge, self.state_of_charge, self.cell_voltage_v)
        return np.asarray(self.cells_in_series * cell)


class Battery(CatalogueRecord):
    """Battery pack described by its mass.

    Temperature, internal resistance and ageing are those of :mod:`sizing.battery.condition`. The
    battery does not depend on air and age without them. ``voltage`` is that of the bus, for a
    propulsion at its operating point. ``cell`` names an entry of the catalogue of batteries, which
    gives the keys that the file omits; ``cell_mass_fraction`` is the cells' share of the pack's
    mass. With ``pack`` the battery has whole cells, whose number gives its mass. No energy is drawn
    below ``minimum_state_of_charge``, the zero of energies and states of charge.
    """

    _entries: ClassVar[Mapping[str, Kind]] = {"cell": "batteries"}

    cell: Text | None = None
    cell_mass_fraction: Fraction = 1.0
    mass_kg: PositiveReal
    specific_energy_wh_per_kg: Annotated[PositiveReal, Field(le=_HIGHEST_WH_PER_KG)]
    charge_efficiency: Fraction = 0.95
    discharge_efficiency: Fraction = 0.97
    charge_limit: ChargeLimit = NoChargeLimit()
    minimum_state_of_charge: Annotated[float, Strict(), Field(ge=0.0, lt=1.0)] = 0.0
    temperature: BatteryTemperature | None = None
    resistance: InternalResistance | None = None
    ageing: Ageing | None = None
    voltage: BatteryVoltage | None = None
    pack: BatteryPack | None = None

    @classmethod
    def completed(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return data with the values of the pack, then of the catalogue's cell."""
        return super().completed(data if data.get("pack") is None else with_pack_values(data))

    @model_validator(mode="wrap")
    @classmethod
    def _with_curve(cls, data: Any, handler: ModelWrapValidatorHandler[Battery]) -> Battery:
        """Add the voltages of the catalogue's cell if the file has none, as a default."""
        voltage = data.get("voltage") if isinstance(data, Mapping) else None
        if not isinstance(voltage, Mapping):
            return handler(data)
        entry = known_entry("batteries", data, "cell")
        keys = ("state_of_charge", "cell_voltage_v")
        if entry is None or entry.kind != "cell" or voltage.keys() & set(keys):
            return handler(data)
        curve = {key: getattr(entry, key) for key in keys}
        record = handler({**data, "voltage": {**curve, **voltage}})
        assert record.voltage is not None
        record.voltage.__pydantic_fields_set__.difference_update(curve)
        return record

    @model_validator(mode="after")
    def _check_cell(self) -> Battery:
        if self.cell is None and self.cell_mass_fraction != 1.0:
            raise wrong_value(
                "cell_mass_fraction", "goes with cell, an entry of the catalogue of batteries"
            )
        if self.minimum_state_of_charge and self.pack is not None and self.pack.usable < 1.0:
            text = "goes without the states of charge of battery.pack: give one floor"
            raise wrong_value("minimum_state_of_charge", text)
        return self

    @property
    def ends_v(self) -> tuple[float, float] | None:
        """Voltages at empty and full usable energy [V]; None without a table of voltages."""
        if self.voltage is None:
            return None
        low, high = self.bus_voltage_v(np.array([0.0, 1.0]))
        return float(low), float(high)

    @property
    def nominal_voltage_v(self) -> float:
        """Voltage of the bus at half of the usable energy, for the simulation of a day [V]."""
        return float(self.bus_voltage_v(np.array(0.5)))

    def bus_voltage_v(self, state_of_charge: FloatArray) -> FloatArray:
        """Return the voltage of the bus at shares of the usable energy [V].

        Usable is the energy above the floor, or in a pack's window of states of charge. The voltage
        is constant outside the table.
        """
        assert self.voltage is not None
        table, least, most = self.voltage.state_of_charge, self.minimum_state_of_charge, 1.0
        if self.pack is not None and not least:
            least, most = self.pack.minimum_state_of_charge, self.pack.maximum_state_of_charge
        charge = least + (most - least) * state_of_charge
        return self.voltage.voltage_v(np.clip(charge, table[0], table[-1]))

    @property
    def battery_energy_wh(self) -> float:
        """Energy at full charge, new and warm, floor included [Wh]."""
        return self.mass_kg * self.specific_energy_wh_per_kg

    @property
    def mean_charge_efficiency(self) -> Value:
        """Mean charge efficiency of a flight, by the internal resistance if given [-]."""
        if self.resistance is None:
            return self.charge_efficiency
        return self.resistance.charge_efficiency(self._resistance_factor)

    @property
    def mean_discharge_efficiency(self) -> Value:
        """Mean discharge efficiency of a flight, by the internal resistance if given [-]."""
        if self.resistance is None:
            return self.discharge_efficiency
        return self.resistance.discharge_efficiency(self._resistance_factor)

    @property
    def _resistance_factor(self) -> Value:
        return 1.0 if self.ageing is None else self.ageing.resistance_factor()

    def temperature_at(self, altitude_m: Value) -> tuple[BatteryTemperature | None, Value]:
        """Return the pack's temperature control at an altitude, and its weight [-].

        Without a temperature in the file, a heater and insulation are assumed in thin air.
        """
        if self.temperature is not None:
            return self.temperature, 1.0
        share = thin_air_share(altitude_m)
        return (HEATED_PACK, share) if np.any(share > 0.0) else (None, 0.0)

    def capacity_fraction(self, air_c: Value, altitude_m: Value = 0.0) -> Value:
        """Return usable capacity at an air temperature and age, over new and warm capacity.

        Parameters
        ----------
        air_c, altitude_m : float or array_like
            Air temperature [C], and altitude, for the assumption of a heater [m].

        Returns
        -------
        float or ndarray
            Share of the capacity [-].
        """
        held, share = self.temperature_at(altitude_m)
        fraction: Value = 1.0
        if held is not None:
            fraction = fraction * held.capacity_fraction(air_c)
            if self.temperature is None:
                fraction = 1.0 - share * (1.0 - fraction)
        if self.ageing is not None:
            fraction = fraction * self.ageing.capacity_fraction()
        return fraction * (1.0 - self.minimum_state_of_charge)

    def heater_w(
        self, air_c: Value, altitude_m: Value = 0.0, mass_kg: Value | None = None
    ) -> Value:
        """Return the power of the heater.

        Parameters
        ----------
        air_c, altitude_m : float or array_like
            Air temperature [C] and altitude [m].
        mass_kg : float or array_like, optional
            Mass of another battery of this kind [kg].

        Returns
        -------
        float or ndarray
            Power, 0 without a heater [W].
        """
        mass = self.mass_kg if mass_kg is None else mass_kg
        fixed, at_1_kg = self.heater_parts_w(air_c, altitude_m)
        return fixed + at_1_kg * mass ** (2.0 / 3.0)

    def heater_parts_w(self, air_c: Value, altitude_m: Value) -> tuple[Value, Value]:
        """Return the heater's power independent of the mass, and for an insulated pack of 1 kg.

        The second scales with the mass to the power of 2/3.

        Parameters
        ----------
        air_c : float or array
            Temperature of the air [C].
        altitude_m : float or array
            Altitude, which broadcasts with it [m].

        Returns
        -------
        fixed_w, at_1_kg_w : float or array
            Both parts [W].
        """
        held, share = self.temperature_at(altitude_m)
        if held is None:
            return 0.0, 0.0
        fixed_w, at_1_kg_w = held.heater_parts_w(air_c)
        return share * fixed_w, share * at_1_kg_w
