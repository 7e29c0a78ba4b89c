"""The battery: energy at full charge, efficiencies, and what air and age make of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, ModelWrapValidatorHandler, Strict, model_validator

from missions.air import thin_air_share
from sizing.battery.charge_limit import ChargeLimit, NoChargeLimit
from sizing.battery.condition import HEATED_PACK, Ageing, BatteryTemperature, InternalResistance
from sizing.battery.pack import BatteryPack, packed
from sizing.battery.voltage import BatteryVoltage
from sizing.catalogues.choice import Kind, OfCatalogue, known_entry
from sizing.smooth import Value
from solar.schema import Fraction, PositiveReal, Text, wrong_value
from solar.types import FloatArray

# No two elements give more energy per mass of what they make than beryllium and oxygen: Gibbs
# energy of formation of BeO 580.1 kJ/mol (CRC Handbook of Chemistry and Physics) over
# 25.012 g/mol. Lithium and fluorine, the elements of batteries, give 6293 Wh/kg.
_HIGHEST_WH_PER_KG = 6443.0


class Battery(OfCatalogue):
    """A battery pack described by its mass.

    Temperature, internal resistance and ageing are those of :mod:`sizing.battery.condition`;
    a battery without them is the same in any air and at any age. ``voltage`` is that of the bus,
    for a propulsion at its operating point. ``cell`` names an entry of the
    catalogue of batteries, which gives what the file does not; the specific energy of a cell counts
    for the share ``cell_mass_fraction`` of the pack's mass. ``pack`` makes it one of whole cells,
    whose mass follows from their number. Below ``minimum_state_of_charge`` nothing is drawn:
    energies and states of charge count from it.
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

    @model_validator(mode="wrap")
    @classmethod
    def _with_pack(cls, data: Any, handler: ModelWrapValidatorHandler[Battery]) -> Battery:
        if not isinstance(data, Mapping) or data.get("pack") is None:
            return handler(data)
        data, new = packed(data)
        record = handler(data)
        record.__pydantic_fields_set__.difference_update(new)
        return record

    @model_validator(mode="wrap")
    @classmethod
    def _with_curve(cls, data: Any, handler: ModelWrapValidatorHandler[Battery]) -> Battery:
        """Table of voltages of the catalogue's cell, where the file has none; it does not count."""
        voltage = data.get("voltage") if isinstance(data, Mapping) else None
        if not isinstance(voltage, Mapping):
            return handler(data)
        entry = known_entry("batteries", data, "cell")
        curve = {} if entry is None else entry.voltage_keys()
        if not curve or curve.keys() & voltage.keys():
            return handler(data)
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
        """Voltages where it counts as empty and as full [V]; None without a table of voltages."""
        if self.voltage is None:
            return None
        low, high = self.bus_voltage_v(np.array([0.0, 1.0]))
        return float(low), float(high)

    @property
    def nominal_voltage_v(self) -> float:
        """Voltage of the bus with a half charged battery, by which a day is flown [V]."""
        return float(self.bus_voltage_v(np.array(0.5)))

    def bus_voltage_v(self, state_of_charge: FloatArray) -> FloatArray:
        """Voltage of the bus at shares of the usable energy [V]; held where the table ends.

        That energy is what lies above the floor, or between the ends of a pack's window.
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
        """Charge efficiency of a flight: of the internal resistance if given, else the file's."""
        if self.resistance is None:
            return self.charge_efficiency
        return self.resistance.charge_efficiency(self._resistance_factor)

    @property
    def mean_discharge_efficiency(self) -> Value:
        """Discharge efficiency of a flight: as :attr:`mean_charge_efficiency`."""
        if self.resistance is None:
            return self.discharge_efficiency
        return self.resistance.discharge_efficiency(self._resistance_factor)

    @property
    def _resistance_factor(self) -> Value:
        return 1.0 if self.ageing is None else self.ageing.resistance_factor()

    def temperature_at(self, altitude_m: Value) -> tuple[BatteryTemperature | None, Value]:
        """What holds the pack's temperature at an altitude, and how much of it counts [-].

        What the file says; else, high up, a heater and insulation.
        """
        if self.temperature is not None:
            return self.temperature, 1.0
        share = thin_air_share(altitude_m)
        return (HEATED_PACK, share) if np.any(share > 0.0) else (None, 0.0)

    def capacity_fraction(self, air_c: Value, altitude_m: Value = 0.0) -> Value:
        """Capacity above the floor, in air of a temperature and at its age, over the new and warm.

        Parameters
        ----------
        air_c, altitude_m : float or array_like
            Air temperature [C], and altitude, from which a heater may be assumed [m].

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
        """Power that its heater draws.

        Parameters
        ----------
        air_c, altitude_m : float or array_like
            Air temperature [C] and altitude [m].
        mass_kg : float or array_like, optional
            Of another battery of its kind [kg].

        Returns
        -------
        float or ndarray
            Power, 0 without a heater [W].
        """
        mass = self.mass_kg if mass_kg is None else mass_kg
        fixed, at_1_kg = self.heater_parts_w(air_c, altitude_m)
        return fixed + at_1_kg * mass ** (2.0 / 3.0)

    def heater_parts_w(self, air_c: Value, altitude_m: Value) -> tuple[Value, Value]:
        """Power of the heater that has no part in the mass, and that of an insulated 1 kg.

        Parameters
        ----------
        air_c, altitude_m : float or array_like
            Air temperature [C] and altitude [m].

        Returns
        -------
        tuple of float or ndarray
            Both [W]; the second grows with the mass to the power of 2/3.
        """
        held, share = self.temperature_at(altitude_m)
        if held is None:
            return 0.0, 0.0
        return share * held.heater_w(air_c), share * held.insulated_heater_w_at_1_kg(air_c)
