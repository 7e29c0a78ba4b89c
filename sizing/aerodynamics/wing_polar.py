"""Drag of an aircraft whose wing has an airfoil with a polar."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from math import pi
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import Field, PrivateAttr, Strict, model_validator

from missions.files.errors import InputError
from missions.files.texts import read_text
from missions.files.validation import wrong_file
from sizing.aerodynamics.airfoil_polar import AirfoilPolar
from sizing.aerodynamics.parabolic import DragPolar, UserDragPolar
from sizing.aerodynamics.polar_table import (
    OF_A_SECTION,
    POLAR_SUFFIXES,
    WingReference,
    is_table_path,
    parse_polar,
)
from sizing.smooth import Value
from solar.schema import (
    CompletedRecord,
    Fraction,
    LiftCoefficient,
    NonNegativeReal,
    PositiveReal,
    Text,
    refusal,
    significant,
    spell,
    wrong_value,
)


def plane_form_factor(thickness_ratio: float) -> float:
    """Return the form factor of a section: Hoerner, Fluid-Dynamic Drag, chapter 6."""
    return 1.0 + 2.0 * thickness_ratio + 60.0 * thickness_ratio**4


class WingPolar(CompletedRecord):
    """Drag of an aircraft from its airfoil's polar, its tail and its fuselage.

    ``C_D = calibration (c_d(c_l, Re) + C_L^2 / (pi e AR) + C_D,tail + C_D,fuselage + C_D,other)``

    * Wing: the polar at ``c_l = section_lift_ratio C_L`` and the Reynolds number of the mean chord.
      The ratio relates the most loaded section to the whole wing. Prandtl's lifting line at
      aspect ratio 18.5 gives 1.05 for a straight centre section with tips tapered to 0.6 over the
      outer 40 % of the span, and 1.08 for a rectangle; an elliptic wing has 1.
    * Tail: laminar flat plate with the form factor of a section, Hoerner, S. F. (1965),
      Fluid-Dynamic Drag, chapters 2 and 6: ``2 x 1.328 Re^-1/2 (1 + 2 t/c + 60 (t/c)^4)``, on
      tails of (0.35 + 0.045)/4 of the wing area (AtlantikSolar's volume ratios with a fuselage of
      four chords). About 0.0105 at a wing Reynolds number of 158 000.
    * Fuselage: turbulent flat plate ``0.074 Re^-1/5`` (Schlichting, Boundary-Layer Theory) on its
      length and wetted area with a form factor (Raymer, D. P., Aircraft Design, section 12.5).
    * Other: interference, gaps, antennas, sensors.

    ``maximum_lift_factor`` reduces the section's greatest lift for gaps, roughness and cells.

    A lift coefficient of null is the optimal one: least power of level flight at the design point,
    no slower than ``stall_margin`` times the stall speed. It is constant for all sized aircraft.
    ``design_reynolds`` is the Reynolds number at ``C_L = 1``: at constant weight level flight has a
    constant ``Re C_L^1/2`` (XFOIL's polars of type 2).

    With ``wing_chord_m`` and ``wing_aspect_ratio`` the polars are those of a whole wing by XFLR5:
    viscous drag replaces the section's drag, and induced drag gives the span efficiency.
    """

    model: Literal["wing_polar"]
    airfoil: Text
    design_aspect_ratio: PositiveReal
    design_reynolds: PositiveReal
    lift_coefficient: LiftCoefficient | None = None
    stall_margin: Annotated[float, Strict(), Field(ge=1.0, allow_inf_nan=False)] = 1.1
    section_lift_ratio: PositiveReal = 1.05
    maximum_lift_factor: Fraction = 1.0
    span_efficiency: Fraction = 0.92
    tail_area_ratio: NonNegativeReal = (0.35 + 0.045) / 4.0
    tail_chord_ratio: PositiveReal = 0.57
    tail_thickness_ratio: NonNegativeReal = 0.08
    fuselage_wetted_area_ratio: NonNegativeReal = 0.15
    fuselage_length_chords: PositiveReal = 4.0
    fuselage_form_factor: PositiveReal = 1.2
    parasitic_drag_coefficient: NonNegativeReal = 0.0
    calibration: PositiveReal = 1.0
    wing_chord_m: PositiveReal | None = None
    wing_aspect_ratio: PositiveReal | None = None
    wing_kinematic_viscosity_m2_per_s: PositiveReal = 1.5e-5

    @classmethod
    def completed(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return data with the values of polars of a wing, as far as these can be read."""
        airfoil = data.get("airfoil")
        if not isinstance(airfoil, str) or not is_table_path(airfoil):
            return data
        keys = ("wing_chord_m", "wing_aspect_ratio", "wing_kinematic_viscosity_m2_per_s")
        values = [data.get(key, 1.5e-5 if key == keys[-1] else None) for key in keys]
        if not all(type(value) in (int, float) and value > 0.0 for value in values):
            return data
        try:
            table = parse_polar(read_text(airfoil, POLAR_SUFFIXES), airfoil, WingReference(*values))
        except InputError:  # which the checks of the record report
            return {"section_lift_ratio": 1.0, **data}
        assert table.span_efficiency is not None  # every polar of a wing has one
        efficiency = significant(table.span_efficiency, 4)
        return {"section_lift_ratio": 1.0, "span_efficiency": efficiency, **data}

    @model_validator(mode="after")
    def _check_wing_and_stall(self) -> WingPolar:
        keys = ("wing_chord_m", "wing_aspect_ratio")
        named = [key for key in keys if getattr(self, key) is not None]
        if len(named) == 1:
            other = keys[keys[0] == named[0]]
            raise wrong_value(named[0], f"goes with {other}")
        if named and not is_table_path(self.airfoil):
            raise wrong_value("airfoil", OF_A_SECTION)
        if named and self.section_lift_ratio != 1.0:
            text = "must be 1 with polars of a wing"
            raise wrong_value("section_lift_ratio", text, got=self.section_lift_ratio)
        try:
            highest = self.highest_lift_coefficient
        except ValueError as error:
            raise wrong_file("airfoil", error) from error
        if self.lift_coefficient is not None and self.lift_coefficient > highest:
            most = f"{spell(highest, 3)}, which is {spell(self.stall_margin)} times the stall speed"
            allowed = f"lift_coefficient must be at most {most}"
            raise ValueError(refusal(allowed, self.lift_coefficient))
        return self

    # Path and text of the airfoil's table, read when the record was made.
    _table: tuple[str, str] | None = PrivateAttr(default=None)

    @cached_property
    def polar(self) -> AirfoilPolar:
        """Polar of the section."""
        text = self.contents_read()
        if text is None:
            return AirfoilPolar.load(self.airfoil)
        return AirfoilPolar.from_table(parse_polar(text, self.airfoil, self.wing))

    @property
    def wing(self) -> WingReference | None:
        """Wing of the polars; None for polars of a section."""
        if self.wing_chord_m is None or self.wing_aspect_ratio is None:
            return None
        return WingReference(
            self.wing_chord_m, self.wing_aspect_ratio, self.wing_kinematic_viscosity_m2_per_s
        )

    def contents_read(self) -> str | None:
        """Return the text of the airfoil's table, read once; None for a shipped airfoil."""
        if not is_table_path(self.airfoil):
            return None
        if self._table is None or self._table[0] != self.airfoil:
            self._table = (self.airfoil, read_text(self.airfoil, POLAR_SUFFIXES))
        return self._table[1]

    @cached_property
    def maximum_lift_coefficient(self) -> float:
        """Lift coefficient of the wing at the stall, at the design point [-]."""
        lift = 1.0
        # Converges at once, as maximum lift hardly changes with the Reynolds number.
        for _ in range(40):
            reynolds = self.design_reynolds / lift**0.5
            highest = self.maximum_lift_factor * float(self.polar.maximum_lift(reynolds))
            lift = highest / self.section_lift_ratio
        return lift

    @property
    def highest_lift_coefficient(self) -> float:
        """Lift coefficient that keeps the stall margin, at the design point [-]."""
        return self.maximum_lift_coefficient / self.stall_margin**2

    @cached_property
    def flight_lift_coefficient(self) -> float:
        """Lift coefficient of level flight: given, or optimal at the design point [-]."""
        if self.lift_coefficient is not None:
            return self.lift_coefficient
        from scipy.optimize import minimize_scalar

        highest = self.highest_lift_coefficient
        grid = np.linspace(0.1 * highest, highest, 200)
        best = int(np.argmin(self._power_measure(grid)))
        bounds = (float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)]))
        least = minimize_scalar(
            self._power_measure, bounds=bounds, method="bounded", options={"xatol": 1e-9}
        )
        candidates = (float(least.x), highest)
        return min(candidates, key=lambda lift: float(self._power_measure(lift)))

    def _power_measure(self, lift: Value) -> Value:
        """Return ``C_D / C_L^1.5`` at the design point, proportional to power of level flight."""
        reynolds = self.design_reynolds * lift**-0.5
        return self.drag_at(lift, self.design_aspect_ratio, reynolds) * lift**-1.5

    def drag_coefficient(self, aspect_ratio: Value, reynolds: Value) -> Value:
        """Return the drag coefficient of the aircraft in level flight, calibrated [-]."""
        return self.drag_at(self.flight_lift_coefficient, aspect_ratio, reynolds)

    def drag_at(self, lift_coefficient: Value, aspect_ratio: Value, reynolds: Value) -> Value:
        """Return the drag coefficient of the aircraft at a lift coefficient, calibrated [-]."""
        profile, induced, other = self.parts(aspect_ratio, reynolds, lift_coefficient)
        return profile + induced + other

    def parts(
        self, aspect_ratio: Value, reynolds: Value, lift_coefficient: Value | None = None
    ) -> tuple[Value, Value, Value]:
        """Return the calibrated coefficients of profile, induced and all other drag [-].

        By the formulas of the class; by default at the lift coefficient of level flight.
        """
        lift = self.flight_lift_coefficient if lift_coefficient is None else lift_coefficient
        tail_form = plane_form_factor(self.tail_thickness_ratio)
        tail = 2.0 * 1.328 * (self.tail_chord_ratio * reynolds) ** -0.5 * tail_form
        fuselage = 0.074 * (self.fuselage_length_chords * reynolds) ** -0.2
        fuselage = self.fuselage_wetted_area_ratio * self.fuselage_form_factor * fuselage
        other = self.tail_area_ratio * tail + fuselage + self.parasitic_drag_coefficient
        profile = self.polar.profile_drag(self.section_lift_ratio * lift, reynolds)
        induced = lift**2 / (pi * self.span_efficiency * aspect_ratio)
        return self.calibration * profile, self.calibration * induced, self.calibration * other


# Drag models of an aircraft's file.
Polar: TypeAlias = DragPolar | WingPolar | UserDragPolar
