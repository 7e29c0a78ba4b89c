"""Strings of solar cells in series, and the voltage window of their MPPT."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import Field, Strict, model_validator

from solar.modules import STC_TEMPERATURE_C
from solar.schema import (
    CellCount,
    NonNegativeReal,
    PositiveReal,
    Record,
    refusal,
    spell,
    spell_ends,
    wrong_value,
)

# Tolerance of rounding for voltages equal to a limit.
_ROUNDING = 1e-9


class Mppt(Record):
    """Maximum power point tracker: voltages and current at its input, and its mass.

    Its input must stay below the battery's voltage if it steps up, and above if it steps down.
    """

    _above: ClassVar[Mapping[str, str]] = {"maximum_voltage_v": "minimum_voltage_v"}

    conversion: Literal["any", "step_up", "step_down"] = "any"
    minimum_voltage_v: PositiveReal
    maximum_voltage_v: PositiveReal
    maximum_current_a: PositiveReal
    mass_kg: NonNegativeReal | None = None


class SeriesWindow(NamedTuple):
    """Least and largest number of cells in series, and the reason in words."""

    least: int
    most: int
    why: str


# From below any air temperature up to 32 km to above the hottest test of modules (IEC 61215: 85 C).
ModuleTemperature = Annotated[float, Strict(), Field(ge=-100.0, le=100.0, allow_inf_nan=False)]


class Strings(Record):
    """Cells in series, strings at an MPPT, and temperatures of the modules [C].

    ``cells_in_series`` is a number for all strings, or a list with the number of each string;
    strings at the same MPPT are neighbours in the list and equally long.

    Voltages and current of a cell hold at 1000 W/m2 and 25 C; their default is in the catalogue's
    entry. ``voltage_coefficient_per_k`` is the relative loss of voltage per kelvin; its default is
    the loss of power, of which that of the current, a gain, is a part.
    """

    _above: ClassVar[Mapping[str, str]] = {"hottest_c": "coldest_c"}

    cells_in_series: CellCount | tuple[CellCount, ...]
    strings_per_mppt: CellCount = 1
    coldest_c: ModuleTemperature
    hottest_c: ModuleTemperature
    mpp_voltage_v: PositiveReal | None = None
    open_circuit_voltage_v: PositiveReal | None = None
    mpp_current_a: PositiveReal | None = None
    voltage_coefficient_per_k: NonNegativeReal | None = None
    mppt: Mppt

    @model_validator(mode="after")
    def _check_cell(self) -> Strings:
        for key in ("mpp_voltage_v", "open_circuit_voltage_v", "mpp_current_a"):
            if getattr(self, key) is None:
                text = "required key is missing: modules.cell names no entry that has it"
                raise wrong_value(key, text)
        if self.cells_in_series == ():
            raise wrong_value("cells_in_series", "must have a number for each string", got="none")
        return self

    def lengths(self, cells: int) -> tuple[int, ...]:
        """Return the number of cells in each string, for a total number of cells."""
        length = self.cells_in_series
        return length if isinstance(length, tuple) else cells // length * (length,)

    def voltage_v(self, at_stc_v: float, temperature_c: float, loss_per_k: float) -> float:
        """Return the voltage of a cell at a temperature [V].

        ``V = V_STC (1 - beta (T - 25 C))``: King, D. L., Boyson, W. E. & Kratochvil, J. A. (2004),
        Photovoltaic Array Performance Model, Sandia National Laboratories SAND2004-3535, eq. 3 and
        4 at full sun.
        """
        loss = self.voltage_coefficient_per_k
        beta = loss_per_k if loss is None else loss
        return max(at_stc_v * (1.0 - beta * (temperature_c - STC_TEMPERATURE_C)), 0.0)

    def window(self, loss_per_k: float, battery_v: tuple[float, float] | None) -> SeriesWindow:
        """Return the numbers of cells in series within the MPPT's voltages.

        ``loss_per_k`` is the relative loss of the modules' power [1/K]; ``battery_v`` the voltages
        of the empty and the full battery [V], for an MPPT that steps up or down.
        """
        mppt, mpp, unloaded = self.mppt, self.mpp_voltage_v, self.open_circuit_voltage_v
        assert mpp is not None
        assert unloaded is not None
        hot_v = self.voltage_v(mpp, self.hottest_c, loss_per_k)
        cold_v = self.voltage_v(mpp, self.coldest_c, loss_per_k)
        open_v = self.voltage_v(unloaded, self.coldest_c, loss_per_k)
        low_v, why = mppt.minimum_voltage_v, ""
        # No cell will do without voltage at its coldest.
        most = mppt.maximum_voltage_v / open_v if open_v > 0.0 else 0.0
        if battery_v is not None and mppt.conversion == "step_up":
            most = min(most, battery_v[0] / cold_v if cold_v > 0.0 else 0.0)
            why = f", below the {spell(battery_v[0], 4)} V of the empty battery"
        if battery_v is not None and mppt.conversion == "step_down":
            low_v = max(low_v, battery_v[1])
            why = f", above the {spell(battery_v[1], 4)} V of the full battery"
        taken = spell_ends((mppt.minimum_voltage_v, mppt.maximum_voltage_v))
        modules = spell_ends((self.coldest_c, self.hottest_c))
        return SeriesWindow(
            least=math.ceil(low_v / hot_v - _ROUNDING) if hot_v > 0.0 else 1 + 10**9,
            most=math.floor(most + _ROUNDING),
            why=f"the MPPT takes {taken} V{why}, the modules have {modules} °C",
        )

    def mppts(self, cells: int) -> int:
        """Return the number of MPPTs for a total number of cells."""
        length = self.cells_in_series
        strings = len(length) if isinstance(length, tuple) else cells / length
        return math.ceil(strings / self.strings_per_mppt - _ROUNDING)

    def problem(
        self, cells: int, loss_per_k: float, battery_v: tuple[float, float] | None
    ) -> tuple[str, str] | None:
        """Return key and text of the first problem of the strings; None if there is none."""
        key, lengths, length = "cells_in_series", self.lengths(cells), self.cells_in_series
        if sum(lengths) != cells:
            if isinstance(length, tuple):
                return key, refusal(f"must be the {cells} cells in all", sum(lengths))
            return key, refusal(f"must divide the {cells} cells into whole strings", length)
        per_mppt = self.strings_per_mppt
        if any(len(set(lengths[i : i + per_mppt])) > 1 for i in range(0, len(lengths), per_mppt)):
            text = f"must be equal in each {per_mppt} strings, which share an MPPT"
            return key, refusal(text, ", ".join(map(str, lengths)))
        window, current = self.window(loss_per_k, battery_v), self.mpp_current_a
        wrong = [n for n in sorted(set(lengths)) if not window.least <= n <= window.most]
        if wrong:
            allowed = (
                f"must be from {window.least} to {window.most}"
                if window.least <= window.most
                else "no number of cells will do"
            )
            return key, refusal(f"{allowed}: {window.why}", wrong[0])
        assert current is not None
        if per_mppt * current > self.mppt.maximum_current_a * (1.0 + _ROUNDING):
            most = math.floor(self.mppt.maximum_current_a / current)
            takes, gives = spell(self.mppt.maximum_current_a), spell(current)
            if most < 1:
                return "mppt", f"takes {takes} A, less than the {gives} A of a string"
            text = f"must be at most {most}: the MPPT takes {takes} A, a string gives {gives} A"
            return "strings_per_mppt", refusal(text, per_mppt)
        return None

    def for_cells(
        self, cells: int, loss_per_k: float, battery_v: tuple[float, float] | None
    ) -> Strings | None:
        """Return the strings with the fewest that divide a number of cells; None if none do."""
        for count in range(1, cells + 1):
            if cells % count == 0:
                strings = self.model_copy(update={"cells_in_series": cells // count})
                if strings.problem(cells, loss_per_k, battery_v) is None:
                    return strings
        return None
