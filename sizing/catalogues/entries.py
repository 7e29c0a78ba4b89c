"""Entries of the catalogues: what data sheets and papers say, and the parameters that follow."""

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
    wrong_value,
)

# Encapsulation and cables of AtlantikSolar's modules, of 0.59 kg/m2 in all (Oettershagen et al.).
ENCAPSULATION_KG_PER_M2 = 0.20
# Voltage of a lithium-ion cell with a carbon anode at a fifth of its capacity an hour: 4.2 V where
# charging ends, 3.0 V where its energy does, flat between (assumption; data sheets have curves).
_USUAL_CHARGE, _USUAL_VOLTAGE_V = (0.0, 0.1, 0.9, 1.0), (3.0, 3.4, 4.0, 4.2)
# Two numbers of one data sheet agree within rounding, and its typical with its guaranteed values.
_AGREEMENT = 0.06

# Keys of an aircraft's file that a propeller's entry may give.
PARTS_OF_PROPELLER = ("diameter_m", "pitch_m", "blades", "chords", "mass_kg")

_Efficiency = Annotated[Fraction, Field(le=HIGHEST_EFFICIENCY)]
_Number = dict[str, float]


class Entry(Record):
    """What is known of a product.

    ``source`` is where its numbers come from; ``sources`` names another one for single numbers.
    """

    # What an entry of this kind may be asked for that it need not have.
    kind_of_entry: ClassVar[str]

    label: Name
    source: Text
    sources: dict[str, Text] = Field(default_factory=dict)
    note: Text | None = None

    @model_validator(mode="after")
    def _check_sources(self) -> Entry:
        odd = [key for key in self.sources if key not in self.numbers()]
        if odd:
            numbers = ", ".join(self.numbers())
            raise wrong_value(f"sources.{odd[0]}", f"is no number of this entry (it has {numbers})")
        return self

    def numbers(self) -> _Number:
        """Numbers that it has, by key."""
        values = ((name, getattr(self, name)) for name in type(self).model_fields)
        return {name: value for name, value in values if isinstance(value, float | int)}

    def source_of(self, key: str) -> str:
        """Where a number comes from."""
        return self.sources.get(key, self.source)

    @abstractmethod
    def parameters(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Keys of an aircraft's file, below the one that names the entry, and their values."""


def _disagree(key: str, text: str, one: float, other: float) -> None:
    """Refuse two values of one quantity that differ by more than data sheets round."""
    if abs(one / other - 1.0) > _AGREEMENT:
        raise wrong_value(
            key,
            f"{text}: {one:.4g} and {other:.4g} do not agree within {100.0 * _AGREEMENT:.0f} %",
        )


def _first_known(*values: float | None) -> float | None:
    """First of values that is known."""
    return next((one for one in values if one is not None), None)


class CellEntry(Entry):
    """A solar cell; currents, voltages and area are those of one cell.

    ``efficiency_stc`` holds at 1000 W/m2 of the spectrum AM1.5 and 25 C. Cells made for space are
    measured outside the atmosphere: ``efficiency_am0`` at ``am0_irradiance_w_per_m2``, 28 C.
    """

    kind_of_entry: ClassVar[str] = "solar cell"

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
        """Power of one cell at its maximum power point [W]."""
        if self.mpp_voltage_v is None or self.mpp_current_a is None:
            return None
        return self.mpp_voltage_v * self.mpp_current_a

    @model_validator(mode="after")
    def _check_physics(self) -> CellEntry:
        for less, more in (
            ("mpp_voltage_v", "open_circuit_voltage_v"),
            ("mpp_current_a", "short_circuit_current_a"),
        ):
            low, high = getattr(self, less), getattr(self, more)
            if low is not None and high is not None and low >= high:
                raise wrong_value(less, f"must be below {more}")
        for key, irradiance in (
            ("efficiency_stc", STC_IRRADIANCE_W_PER_M2),
            ("efficiency_am0", self.am0_irradiance_w_per_m2),
        ):
            efficiency, power, area = getattr(self, key), self.mpp_power_w, self.area_m2
            if efficiency is None or irradiance is None or power is None or area is None:
                continue
            text = "efficiency, and power over light on the area"
            _disagree(key, text, efficiency, power / (area * irradiance))
        return self

    def parameters(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Efficiency, temperature coefficient, and mass with AtlantikSolar's encapsulation."""
        if self.efficiency_stc is None and given.get("efficiency_stc") is None:
            am0 = self.efficiency_am0
            only = "none" if am0 is None else f"{am0:g} outside the atmosphere"
            text = f"the catalogue has no efficiency under AM1.5 of {self.label} (only {only}): "
            raise wrong_value("cell", f"{text}give efficiency_stc")
        mass = self.mass_kg_per_m2
        values = {
            "efficiency_stc": self.efficiency_stc,
            "temperature_coefficient_per_k": self.temperature_coefficient_per_k,
            "mass_kg_per_m2": None if mass is None else round(mass + ENCAPSULATION_KG_PER_M2, 6),
        }
        return {key: value for key, value in values.items() if value is not None}


class BatteryEntry(Entry):
    """A battery cell, or a whole pack.

    What counts is what a data sheet guarantees: ``capacity_ah`` and ``energy_wh`` are its least
    ones, ``mass_kg`` is its largest. The keys with ``typical_`` are its typical ones, and count
    where it has no others. The energy is voltage times capacity where it is not given.
    ``specific_energy_wh_per_kg`` is what the source states, and counts where there is no mass.
    ``cell_voltage_v`` over ``state_of_charge`` is the voltage at the currents of the flight, by
    default that of a usual lithium-ion cell; a pack has none.
    """

    kind_of_entry: ClassVar[str] = "battery"

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
    def _check_typical(self) -> BatteryEntry:
        for less, more in (
            ("capacity_ah", "typical_capacity_ah"),
            ("energy_wh", "typical_energy_wh"),
            ("typical_mass_kg", "mass_kg"),
        ):
            low, high = getattr(self, less), getattr(self, more)
            if low is not None and high is not None and low > high:
                raise wrong_value(less, f"must be at most {more}, which is {high:g} (got {low:g})")
        return self

    @model_validator(mode="after")
    def _check_physics(self) -> BatteryEntry:
        for prefix in ("", "typical_"):
            energy = getattr(self, f"{prefix}energy_wh")
            product = self._times_voltage(getattr(self, f"{prefix}capacity_ah"))
            if energy is not None and product is not None:
                key = f"{prefix}energy_wh"
                _disagree(key, "energy, and voltage times capacity", energy, product)
        # Makers state the typical value, or the guaranteed one.
        key, stated = "specific_energy_wh_per_kg", self.specific_energy_wh_per_kg
        ratios = self._energies_over_mass
        if ratios and stated is not None:
            nearest = min(ratios, key=lambda ratio: abs(ratio - stated))
            _disagree(key, "specific energy, and energy over mass", stated, nearest)
        if not ratios and stated is None:
            text = "or mass_kg with energy_wh (or with nominal_voltage_v and capacity_ah) is needed"
            raise wrong_value(key, text)
        return self

    def _times_voltage(self, capacity_ah: float | None) -> float | None:
        if self.nominal_voltage_v is None or capacity_ah is None:
            return None
        return self.nominal_voltage_v * capacity_ah

    @property
    def _least_energy(self) -> float | None:
        return _first_known(self.energy_wh, self._times_voltage(self.capacity_ah))

    @property
    def _typical_energy(self) -> float | None:
        return _first_known(self.typical_energy_wh, self._times_voltage(self.typical_capacity_ah))

    @property
    def _energies_over_mass(self) -> list[float]:
        """Wh/kg of the energies that are known, the one that counts first."""
        mass = self.mass
        energies = (self._least_energy, self._typical_energy)
        return [] if mass is None else [one / mass for one in energies if one is not None]

    @property
    def capacity(self) -> float | None:
        """Capacity that counts [Ah]: the least, else the typical one."""
        return _first_known(self.capacity_ah, self.typical_capacity_ah)

    @property
    def energy(self) -> float | None:
        """Energy that counts [Wh], None where it is not known."""
        return _first_known(self._least_energy, self._typical_energy)

    @property
    def mass(self) -> float | None:
        """Mass that counts [kg]: the largest, else the typical one."""
        return _first_known(self.mass_kg, self.typical_mass_kg)

    @property
    def specific_energy(self) -> float:
        """Energy over mass, else what the source gives [Wh/kg]."""
        known = _first_known(*self._energies_over_mass, self.specific_energy_wh_per_kg)
        assert known is not None  # refused at validation
        return known

    def voltage_keys(self) -> dict[str, Any]:
        """Table of voltages of ``battery.voltage``; empty for a pack."""
        keys = ("state_of_charge", "cell_voltage_v")
        return {key: getattr(self, key) for key in keys} if self.kind == "cell" else {}

    @property
    def basis(self) -> Literal["min/max", "typical", "stated", "pack"]:
        """What the specific energy is: least energy over largest mass, or what else there is."""
        if self.kind == "pack":
            return "pack"
        if not self._energies_over_mass:
            return "stated"
        guaranteed = self._least_energy is not None and self.mass_kg is not None
        return "min/max" if guaranteed else "typical"

    @property
    def charge_rate_per_h(self) -> float | None:
        """Largest charge current over capacity [1/h]."""
        capacity = self.capacity
        if self.maximum_charge_current_a is None or capacity is None:
            return None
        return self.maximum_charge_current_a / capacity

    @property
    def loss_at_1c(self) -> float | None:
        """Share of the voltage that the resistance takes at 1 C, ``R C / U`` [-]."""
        resistance, voltage, capacity = (
            self.dc_resistance_ohm,
            self.nominal_voltage_v,
            self.capacity,
        )
        if resistance is None or voltage is None or capacity is None:
            return None
        return resistance * capacity / voltage

    def parameters(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Specific energy of the pack, and the charge limit where its current is known."""
        share = given.get("cell_mass_fraction", 1.0)
        if self.kind == "pack" and "cell_mass_fraction" in given:
            text = f"is of no use here: {self.label} is a whole pack, not a cell"
            raise wrong_value("cell_mass_fraction", text)
        number = isinstance(share, float | int) and not isinstance(share, bool)
        energy = self.specific_energy * (share if number else 1.0)
        values: dict[str, Any] = {"specific_energy_wh_per_kg": float(f"{energy:.6g}")}
        if self.charge_rate_per_h is not None:
            rate = float(f"{self.charge_rate_per_h:.6g}")
            values["charge_limit"] = {"kind": "rule", "c_rate_per_h": rate}
        return values


class MotorEntry(Entry):
    """An electric motor, by the constants of the first-order model."""

    kind_of_entry: ClassVar[str] = "motor"

    speed_constant_rpm_per_v: PositiveReal
    resistance_ohm: PositiveReal
    no_load_current_a: PositiveReal
    nominal_voltage_v: PositiveReal | None = None
    maximum_current_a: PositiveReal | None = None
    mass_kg: PositiveReal | None = None

    def best_efficiency(self, voltage_v: float) -> float:
        """Efficiency at the current where it is greatest [-].

        ``(1 - sqrt(I_0 R / U))^2``, at the current ``sqrt(U I_0 / R)``: Drela, M. (2007),
        First-Order DC Electric Motor Model, MIT Aero & Astro, from its equations for the torque and
        the speed. At any other current it is less, in level flight as well.
        """
        least = self.no_load_current_a * self.resistance_ohm
        if voltage_v <= least:
            raise wrong_value(
                "motor_voltage_v",
                f"must be above {least:.3g} V, at which {self.label} begins to turn (got "
                f"{voltage_v:g})",
            )
        return (1.0 - sqrt(least / voltage_v)) ** 2

    def parameters(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Motor efficiency at the voltage of the file, else at the motor's nominal one."""
        voltage = given.get("motor_voltage_v")
        voltage = self.nominal_voltage_v if voltage is None else voltage
        if voltage is None:
            if given.get("motor_efficiency") is not None:
                return {"motor_efficiency": given["motor_efficiency"]}
            text = f"required key is missing: {self.label} has no nominal voltage"
            raise wrong_value("motor_voltage_v", text)
        if not isinstance(voltage, float | int) or isinstance(voltage, bool):
            return {}  # refused by the record
        return {"motor_efficiency": float(f"{self.best_efficiency(voltage):.6g}")}


class MpptEntry(Entry):
    """A maximum power point tracker as a board; voltages and current are those at its input.

    ``rated_power_w`` is the power of modules that a board takes. ``efficiency`` is the least that
    the source states and counts, ``peak_efficiency`` the greatest.
    """

    kind_of_entry: ClassVar[str] = "MPPT"

    mass_kg: PositiveReal
    rated_power_w: PositiveReal
    efficiency: Fraction | None = None
    peak_efficiency: Fraction | None = None
    conversion: Literal["any", "step_up", "step_down"] | None = None
    minimum_voltage_v: PositiveReal | None = None
    maximum_voltage_v: PositiveReal | None = None
    maximum_current_a: PositiveReal | None = None

    @model_validator(mode="after")
    def _check_order(self) -> MpptEntry:
        for less, more in (
            ("minimum_voltage_v", "maximum_voltage_v"),
            ("efficiency", "peak_efficiency"),
        ):
            low, high = getattr(self, less), getattr(self, more)
            if low is not None and high is not None and low > high:
                raise wrong_value(less, f"must be at most {more}, which is {high:g} (got {low:g})")
        return self

    @property
    def mass_kg_per_w(self) -> float:
        """Mass over the power that it takes [kg/W]."""
        return self.mass_kg / self.rated_power_w

    def parameters(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Efficiency where it is known, and mass per watt."""
        values = {
            "mppt_efficiency": self.efficiency,
            "mppt_mass_kg_per_w": float(f"{self.mass_kg_per_w:.6g}"),
        }
        return {key: value for key, value in values.items() if value is not None}

    def window(self) -> dict[str, Any]:
        """Keys of the MPPT of strings of whole cells, as far as they are known."""
        keys = (
            "conversion",
            "minimum_voltage_v",
            "maximum_voltage_v",
            "maximum_current_a",
            "mass_kg",
        )
        values = {key: getattr(self, key) for key in keys}
        return {key: value for key, value in values.items() if value is not None}


class PropellerEntry(Entry):
    """A propeller: its size, and the greatest efficiency that is known of it.

    ``computed_efficiency_3000_rpm`` is the greatest of the maker's table at that speed;
    ``measured_efficiency`` the greatest of a run in a wind tunnel at ``measured_rpm``.
    """

    kind_of_entry: ClassVar[str] = "propeller"

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
            message = "goes with measured_efficiency: give both or none"
            raise wrong_value("measured_rpm", message)
        return self

    def parameters(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Diameter, pitch, blades and what else is known; blade elements give the efficiency.

        With a table only diameter and mass: the table has the coefficients.
        """
        with_table = given.get("table") is not None
        names = ("diameter_m", "mass_kg") if with_table else PARTS_OF_PROPELLER
        values = {name: getattr(self, name) for name in names}
        return {name: value for name, value in values.items() if value is not None}
