"""Entries of the catalogues: numbers of data sheets and papers, and parameters that follow."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from math import sqrt
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from solar.modules import HIGHEST_EFFICIENCY, STC_IRRADIANCE_W_PER_M2
from solar.schema import (
    Fraction,
    Name,
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Record,
    Text,
    UnitInterval,
    significant,
    spell,
    wrong_value,
)

# Encapsulation and cables of AtlantikSolar's modules, which have 0.59 kg/m2 (Oettershagen et al.).
ENCAPSULATION_KG_PER_M2 = 0.20
# Voltage of a lithium-ion cell with a carbon anode at C/5: 4.2 V at full and 3.0 V at empty, flat
# between (assumption; data sheets have curves).
_USUAL_CHARGE, _USUAL_VOLTAGE_V = (0.0, 0.1, 0.9, 1.0), (3.0, 3.4, 4.0, 4.2)
# Relative tolerance of related numbers in a data sheet, of typical and guaranteed values too.
_AGREEMENT = 0.06

# Keys of an aircraft's file that a propeller's entry may give.
PARTS_OF_PROPELLER = ("diameter_m", "pitch_m", "blades", "chords", "mass_kg")

_Efficiency = Annotated[Fraction, Field(le=HIGHEST_EFFICIENCY)]


class Entry(Record):
    """Product of a catalogue.

    ``source`` is the source of all numbers but those in ``sources``, which have others.
    """

    label: Name
    source: Text
    sources: dict[str, Text] = Field(default_factory=dict)
    note: Text | None = None

    @model_validator(mode="after")
    def _check_numbers(self) -> Entry:
        odd = [key for key in self.sources if key not in self.numbers()]
        if odd:
            numbers = ", ".join(self.numbers())
            raise wrong_value(f"sources.{odd[0]}", f"is no number of this entry (it has {numbers})")
        return self

    def known(self, *keys: str) -> dict[str, Any]:
        """Return the values of the keys that the entry has."""
        return {key: value for key in keys if (value := getattr(self, key)) is not None}

    def numbers(self) -> dict[str, float]:
        """Return the numbers of the entry by their keys."""
        values = ((name, getattr(self, name)) for name in type(self).model_fields)
        return {name: value for name, value in values if isinstance(value, float | int)}

    def source_of(self, key: str) -> str:
        """Return the source of a number."""
        return self.sources.get(key, self.source)

    @abstractmethod
    def parameters(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Return parameters of an aircraft's file from the entry, by their keys."""


def _check_agreement(key: str, text: str, first: float, second: float) -> None:
    """Refuse two values of a quantity that differ by more than the rounding of data sheets."""
    if abs(first / second - 1.0) > _AGREEMENT:
        both = f"{spell(first, 4)} and {spell(second, 4)}"
        within = f"do not agree within {round(100.0 * _AGREEMENT)} %"
        raise wrong_value(key, f"{text}: {both} {within}")


def _first_known(*values: float | None) -> float | None:
    """Return the first known value."""
    return next((value for value in values if value is not None), None)


class CellEntry(Entry):
    """Solar cell; currents, voltages and area are of a single cell.

    ``efficiency_stc`` holds at 1000 W/m2 of the spectrum AM1.5 and 25 C. Cells made for space are
    measured outside the atmosphere: ``efficiency_am0`` at ``am0_irradiance_w_per_m2``, 28 C.
    """

    _above: ClassVar[Mapping[str, str]] = {
        "open_circuit_voltage_v": "mpp_voltage_v",
        "short_circuit_current_a": "mpp_current_a",
    }

    efficiency_stc: _Efficiency | None = None
    efficiency_am0: _Efficiency | None = None
    am0_irradiance_w_per_m2: PositiveReal | None = None
    temperature_coefficient_per_k: NonNegativeReal | None = None
    area_m2: PositiveReal | None = None
    mass_kg_per_m2: PositiveReal | None = None
    mpp_voltage_v: PositiveReal | None = None
    mpp_current_a: PositiveReal | None = None
    open_circuit_voltage_v: PositiveReal | None = None
    short_circuit_current_a: PositiveReal | None = None

    @property
    def mpp_power_w(self) -> float | None:
        """Power of a cell at its maximum power point [W]."""
        voltage, current = self.mpp_voltage_v, self.mpp_current_a
        return None if voltage is None or current is None else voltage * current

    @model_validator(mode="after")
    def _check_physics(self) -> CellEntry:
        for key, irradiance in (
            ("efficiency_stc", STC_IRRADIANCE_W_PER_M2),
            ("efficiency_am0", self.am0_irradiance_w_per_m2),
        ):
            efficiency, power, area = getattr(self, key), self.mpp_power_w, self.area_m2
            if efficiency is None or irradiance is None or power is None or area is None:
                continue
            text = "efficiency, and power over light on the area"
            _check_agreement(key, text, efficiency, power / (area * irradiance))
        return self

    def parameters(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Return efficiency, temperature coefficient, and mass with encapsulation."""
        if self.efficiency_stc is None and data.get("efficiency_stc") is None:
            am0 = self.efficiency_am0
            only = "none" if am0 is None else f"{spell(am0)} outside the atmosphere"
            text = f"the catalogue has no efficiency under AM1.5 of {self.label} (only {only}): "
            raise wrong_value("cell", f"{text}give efficiency_stc")
        values = self.known("efficiency_stc", "temperature_coefficient_per_k", "mass_kg_per_m2")
        if "mass_kg_per_m2" in values:
            values["mass_kg_per_m2"] = round(values["mass_kg_per_m2"] + ENCAPSULATION_KG_PER_M2, 6)
        return values


class BatteryEntry(Entry):
    """Battery cell, or a whole pack.

    Guaranteed values have precedence: least ``capacity_ah`` and ``energy_wh``, largest ``mass_kg``.
    Keys with ``typical_`` are used where these are unknown. The energy is voltage times capacity
    by default. ``specific_energy_wh_per_kg`` is the source's own value, used without a mass.
    ``cell_voltage_v`` over ``state_of_charge`` is the voltage at the currents of the flight, by
    default of a usual lithium-ion cell; a pack has none.
    """

    _not_below: ClassVar[Mapping[str, str]] = {
        "typical_capacity_ah": "capacity_ah",
        "typical_energy_wh": "energy_wh",
        "mass_kg": "typical_mass_kg",
    }

    kind: Literal["cell", "pack"] = "cell"
    nominal_voltage_v: PositiveReal | None = None
    capacity_ah: PositiveReal | None = None
    typical_capacity_ah: PositiveReal | None = None
    energy_wh: PositiveReal | None = None
    typical_energy_wh: PositiveReal | None = None
    mass_kg: PositiveReal | None = None
    typical_mass_kg: PositiveReal | None = None
    specific_energy_wh_per_kg: PositiveReal | None = None
    maximum_charge_current_a: PositiveReal | None = None
    dc_resistance_ohm: PositiveReal | None = None
    state_of_charge: tuple[UnitInterval, ...] = _USUAL_CHARGE
    cell_voltage_v: tuple[PositiveReal, ...] = _USUAL_VOLTAGE_V

    @model_validator(mode="after")
    def _check_physics(self) -> BatteryEntry:
        for prefix in ("", "typical_"):
            energy, product = self._energies(prefix)
            if energy is not None and product is not None:
                key = f"{prefix}energy_wh"
                _check_agreement(key, "energy, and voltage times capacity", energy, product)
        # Makers state the typical or the guaranteed value.
        key, stated = "specific_energy_wh_per_kg", self.specific_energy_wh_per_kg
        ratios = self._energies_over_mass
        if ratios and stated is not None:
            nearest = min(ratios, key=lambda ratio: abs(ratio - stated))
            _check_agreement(key, "specific energy, and energy over mass", stated, nearest)
        if not ratios and stated is None:
            text = "or mass_kg with energy_wh (or with nominal_voltage_v and capacity_ah) is needed"
            raise wrong_value(key, text)
        return self

    def _energies(self, prefix: str = "") -> tuple[float | None, float | None]:
        """Return the energy, and voltage times capacity; ``prefix``: ``typical_`` or none."""
        voltage, capacity = self.nominal_voltage_v, getattr(self, f"{prefix}capacity_ah")
        product = None if voltage is None or capacity is None else voltage * capacity
        return getattr(self, f"{prefix}energy_wh"), product

    @property
    def _energies_over_mass(self) -> list[float]:
        """Known specific energies, guaranteed before typical [Wh/kg]."""
        mass = self.mass
        energies = (_first_known(*self._energies(prefix)) for prefix in ("", "typical_"))
        return [] if mass is None else [energy / mass for energy in energies if energy is not None]

    @property
    def capacity(self) -> float | None:
        """Least capacity, else the typical one [Ah]."""
        return _first_known(self.capacity_ah, self.typical_capacity_ah)

    @property
    def energy(self) -> float | None:
        """Least energy, else the typical one; None if unknown [Wh]."""
        return _first_known(*self._energies(), *self._energies("typical_"))

    @property
    def mass(self) -> float | None:
        """Largest mass, else the typical one [kg]."""
        return _first_known(self.mass_kg, self.typical_mass_kg)

    @property
    def specific_energy(self) -> float:
        """Energy over mass, else the source's value [Wh/kg]."""
        known = _first_known(*self._energies_over_mass, self.specific_energy_wh_per_kg)
        assert known is not None  # refused at validation
        return known

    @property
    def basis(self) -> Literal["min/max", "typical", "stated", "pack"]:
        """Basis of the specific energy: guaranteed, typical or stated values, or a pack's."""
        if self.kind == "pack":
            return "pack"
        if not self._energies_over_mass:
            return "stated"
        guaranteed = _first_known(*self._energies()) is not None and self.mass_kg is not None
        return "min/max" if guaranteed else "typical"

    @property
    def charge_rate_per_h(self) -> float | None:
        """Largest charge current over capacity [1/h]."""
        current, capacity = self.maximum_charge_current_a, self.capacity
        return None if current is None or capacity is None else current / capacity

    @property
    def loss_at_1c(self) -> float | None:
        """Share of the voltage lost at the resistance at 1 C, ``R C / U`` [-]."""
        ohm, voltage, capacity = self.dc_resistance_ohm, self.nominal_voltage_v, self.capacity
        if ohm is None or voltage is None or capacity is None:
            return None
        return ohm * capacity / voltage

    def parameters(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Return the specific energy of the pack, and the charge limit if its current is known."""
        share = data.get("cell_mass_fraction", 1.0)
        if self.kind == "pack" and "cell_mass_fraction" in data:
            text = f"is of no use here: {self.label} is a whole pack, not a cell"
            raise wrong_value("cell_mass_fraction", text)
        number = isinstance(share, float | int) and not isinstance(share, bool)
        energy = self.specific_energy * (share if number else 1.0)
        values: dict[str, Any] = {"specific_energy_wh_per_kg": significant(energy)}
        if self.charge_rate_per_h is not None:
            rate = significant(self.charge_rate_per_h)
            values["charge_limit"] = {"kind": "rule", "c_rate_per_h": rate}
        return values


class MotorEntry(Entry):
    """Electric motor, by the constants of the first-order model."""

    speed_constant_rpm_per_v: PositiveReal
    resistance_ohm: PositiveReal
    no_load_current_a: PositiveReal
    nominal_voltage_v: PositiveReal | None = None
    maximum_current_a: PositiveReal | None = None
    mass_kg: PositiveReal | None = None

    def best_efficiency(self, voltage_v: float) -> float:
        """Return the greatest efficiency over current at a voltage [-].

        ``(1 - sqrt(I_0 R / U))^2``, at the current ``sqrt(U I_0 / R)``: Drela, M. (2007),
        First-Order DC Electric Motor Model, MIT Aero & Astro, from its equations for the torque and
        the speed. At any other current it is less.
        """
        least = self.no_load_current_a * self.resistance_ohm
        if voltage_v <= least:
            text = f"must be above {spell(least, 3)} V, at which {self.label} begins to turn"
            raise wrong_value("motor_voltage_v", text, got=voltage_v)
        return (1.0 - sqrt(least / voltage_v)) ** 2

    def parameters(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Return the motor efficiency at the file's voltage, else at the nominal voltage."""
        voltage = data.get("motor_voltage_v")
        voltage = self.nominal_voltage_v if voltage is None else voltage
        if voltage is None:
            if data.get("motor_efficiency") is not None:
                return {"motor_efficiency": data["motor_efficiency"]}
            text = f"required key is missing: {self.label} has no nominal voltage"
            raise wrong_value("motor_voltage_v", text)
        if not isinstance(voltage, float | int) or isinstance(voltage, bool):
            return {}  # refused by the record
        return {"motor_efficiency": significant(self.best_efficiency(voltage))}


class MpptEntry(Entry):
    """Board of a maximum power point tracker; voltages and current are those at its input.

    ``rated_power_w`` is the largest power of the modules. ``efficiency`` is the least in the
    source, ``peak_efficiency`` the greatest.
    """

    _not_below: ClassVar[Mapping[str, str]] = {
        "maximum_voltage_v": "minimum_voltage_v",
        "peak_efficiency": "efficiency",
    }

    mass_kg: PositiveReal
    rated_power_w: PositiveReal
    efficiency: Fraction | None = None
    peak_efficiency: Fraction | None = None
    conversion: Literal["any", "step_up", "step_down"] | None = None
    minimum_voltage_v: PositiveReal | None = None
    maximum_voltage_v: PositiveReal | None = None
    maximum_current_a: PositiveReal | None = None

    @property
    def mass_kg_per_w(self) -> float:
        """Mass over rated power [kg/W]."""
        return self.mass_kg / self.rated_power_w

    def parameters(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Return the efficiency if known, and the mass per watt."""
        known = {} if self.efficiency is None else {"mppt_efficiency": self.efficiency}
        return known | {"mppt_mass_kg_per_w": significant(self.mass_kg_per_w)}

    def window(self) -> dict[str, Any]:
        """Return the known keys of the MPPT of strings of whole cells."""
        ends = ("minimum_voltage_v", "maximum_voltage_v", "maximum_current_a")
        return self.known("conversion", *ends, "mass_kg")


class PropellerEntry(Entry):
    """Propeller: its size, and its greatest known efficiency.

    ``computed_efficiency_3000_rpm`` is the greatest in the maker's table at that speed;
    ``measured_efficiency`` the greatest in a wind tunnel run at ``measured_rpm``.
    """

    diameter_m: PositiveReal
    pitch_m: PositiveReal
    blades: PositiveInteger = 2
    chords: Literal["thin_electric", "slow_flyer"] | None = None
    mass_kg: PositiveReal | None = None
    measured_efficiency: Fraction | None = None
    measured_rpm: PositiveReal | None = None
    computed_efficiency_3000_rpm: Fraction | None = None

    @model_validator(mode="after")
    def _check_measurement(self) -> PropellerEntry:
        if (self.measured_efficiency is None) != (self.measured_rpm is None):
            raise wrong_value("measured_rpm", "goes with measured_efficiency: give both or none")
        return self

    def parameters(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Return diameter, pitch, blades, chords and mass, as far as known.

        With a table, which has the coefficients, only diameter and mass.
        """
        with_table = data.get("table") is not None
        return self.known(*(("diameter_m", "mass_kg") if with_table else PARTS_OF_PROPELLER))
