"""Power over airspeed: the wing-polar model beside flights of AtlantikSolar.

Two aircraft are compared. AS-2's level-flight power is one published number. AS-1 was flown at
eleven airspeeds, each a mean over 200 s: Oettershagen, P. et al. (2015), A Solar-Powered
Hand-Launchable UAV for Low-Altitude Multi-Day Continuous Flight, ICRA 2015.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.validation.built_aircraft import ATLANTIKSOLAR
from benchmarks.validation.figure_script import write_figure
from missions.air import GRAVITY_M_PER_S2
from sizing.aerodynamics.parabolic import level_airspeed_m_per_s
from sizing.aerodynamics.polar_table import shipped_airfoils
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.smooth import Value
from solar.types import FloatArray
from studies.output.figures.drawing import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    Canvas,
    ink,
    new_figure,
    styled,
    to_bytes,
)
from studies.output.figures.options import DEFAULT, FigureOptions
from studies.render.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = (BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION)
# Told apart without their colours too.
_LINES = ("-", "--", "-.", ":", (0, (8, 2)), (0, (3, 1, 1, 1, 1, 1)))
_MARKERS = "osD^v*"


@dataclass(frozen=True)
class PowerCase:
    """An aircraft in level flight; ``constant_power_w`` is what the measurement includes besides.

    Viscosity is that of standard air at 15 C.
    """

    name: str
    mass_kg: float
    wingspan_m: float
    aspect_ratio: float
    density_kg_per_m3: float
    propulsion_efficiency: float
    constant_power_w: float
    dynamic_viscosity: float = 1.789e-5

    @property
    def wing_area_m2(self) -> float:
        """Wing area [m2]."""
        return self.wingspan_m**2 / self.aspect_ratio

    def lift_coefficient(self, airspeed_m_per_s: Value) -> Value:
        """Lift coefficient of level flight [-]."""
        pressure = 0.5 * self.density_kg_per_m3 * airspeed_m_per_s**2
        return self.mass_kg * GRAVITY_M_PER_S2 / (pressure * self.wing_area_m2)

    def reynolds(self, airspeed_m_per_s: Value) -> Value:
        """Reynolds number of the mean chord [-]."""
        chord_m = self.wingspan_m / self.aspect_ratio
        return self.density_kg_per_m3 * airspeed_m_per_s * chord_m / self.dynamic_viscosity

    def design_reynolds(self) -> float:
        """Reynolds number at a lift coefficient of 1, as :class:`WingPolar` asks for it."""
        return float(self.reynolds(self.lift_coefficient(1.0) ** 0.5))

    def electric_power_w(self, polar: WingPolar, airspeed_m_per_s: Value) -> Value:
        """Electric power of level flight [W].

        Parameters
        ----------
        polar : WingPolar
            Drag of the wing.
        airspeed_m_per_s : float or ndarray
            True airspeed [m/s].

        Returns
        -------
        float or ndarray
        """
        v = airspeed_m_per_s
        drag = polar.drag_at(self.lift_coefficient(v), self.aspect_ratio, self.reynolds(v))
        power = 0.5 * self.density_kg_per_m3 * v**3 * self.wing_area_m2 * drag
        return power / self.propulsion_efficiency + self.constant_power_w


_WING = ATLANTIKSOLAR.wingspan_m, ATLANTIKSOLAR.aspect_ratio, ATLANTIKSOLAR.density_kg_per_m3
# Published: the four efficiencies of the chain.
AS2 = PowerCase(
    *("AtlantikSolar AS-2", ATLANTIKSOLAR.total_mass_kg),
    *(*_WING, 0.97 * 0.82 * 0.96 * 0.82, 0.0),
)
AS2_POWER_W = ATLANTIKSOLAR.level_flight_w
# Published: mass, efficiency 0.58, avionics 4.5 W, taken as part of the measured power. The density
# is an assumption: that of AS-2's measurement, at the same airfield in summer.
AS1 = PowerCase("AtlantikSolar AS-1", 7.36, *_WING, 0.58, 4.5)
# Airspeed [m/s] and electric power [W].
AS1_FLIGHT = (
    (8.12, 71.1),
    (8.52, 56.1),
    (8.98, 52.5),
    (9.42, 44.0),
    (9.63, 40.3),
    (10.00, 45.4),
    (10.63, 51.1),
    (11.44, 71.9),
    (12.48, 84.6),
    (13.52, 87.0),
    (14.52, 109.4),
)


class LevelFlightCheck(NamedTuple):
    """AS-2 with one airfoil, nothing calibrated: where it flies and what it draws."""

    airfoil: str
    lift_coefficient: float
    airspeed_m_per_s: float
    electric_power_w: float
    calibration: float


class CurveCheck(NamedTuple):
    """A power curve beside the flight of AS-1; residuals are model less measurement [W]."""

    polar: WingPolar
    airspeed_m_per_s: FloatArray
    measured_w: FloatArray
    modelled_w: FloatArray

    @property
    def residual_w(self) -> FloatArray:
        """Model less measurement [W]."""
        return self.modelled_w - self.measured_w

    @property
    def bias_w(self) -> float:
        """Mean residual [W]."""
        return float(np.mean(self.residual_w))

    @property
    def rms_w(self) -> float:
        """Root of the mean square residual [W]."""
        return float(np.sqrt(np.mean(self.residual_w**2)))


def wing_polar(airfoil: str, case: PowerCase, *, calibration: float = 1.0) -> WingPolar:
    """Wing polar of a case with the defaults for everything else, and its best lift.

    Parameters
    ----------
    airfoil : str
        Name of a shipped airfoil.
    case : PowerCase
        Aircraft whose chord gives the Reynolds number.
    calibration : float
        Factor on the drag [-].

    Returns
    -------
    WingPolar
    """
    return WingPolar(
        model="wing_polar",
        airfoil=airfoil,
        design_aspect_ratio=case.aspect_ratio,
        design_reynolds=case.design_reynolds(),
        calibration=calibration,
    )


def check_level_flight() -> list[LevelFlightCheck]:
    """AS-2 with every shipped airfoil; ``calibration`` would give the measured power."""
    return [_level_flight(airfoil) for airfoil in shipped_airfoils()]


def _level_flight(airfoil: str) -> LevelFlightCheck:
    polar = wing_polar(airfoil, AS2)
    lift, loading = polar.flight_lift_coefficient, AS2.mass_kg / AS2.wing_area_m2
    speed = level_airspeed_m_per_s(lift, loading, AS2.density_kg_per_m3)
    power = AS2.electric_power_w(polar, speed)
    return LevelFlightCheck(airfoil, lift, speed, power, AS2_POWER_W / power)


def check_curve(polar: WingPolar, case: PowerCase = AS1) -> CurveCheck:
    """Power curve at the airspeeds of AS-1's flight.

    Parameters
    ----------
    polar : WingPolar
        Drag of the wing.
    case : PowerCase
        Aircraft that flew.

    Returns
    -------
    CurveCheck
    """
    speed, measured = np.asarray(AS1_FLIGHT).T
    return CurveCheck(polar, speed, measured, case.electric_power_w(polar, speed))


@styled
def power_curve_figure(
    polars: list[WingPolar], case: PowerCase = AS1, *, figure: Canvas = DEFAULT
) -> Figure:
    """Power over airspeed with each polar, the flight's eleven points, and the residuals.

    Parameters
    ----------
    polars : list of WingPolar
        A curve each.
    case : PowerCase
        Aircraft that flew.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure
    """
    drawn, (axes, residual_axes) = new_figure(
        2,
        canvas=figure,
        title=f"{case.name}: power of level flight",
        notes=(f"{case.mass_kg:g} kg, air of {case.density_kg_per_m3:g} kg/m³",),
        size_in=(8.0, 6.2),
        sharex=True,
        height_ratios=(2, 1),
    )
    flight = np.asarray(AS1_FLIGHT)
    for index, polar in enumerate(polars):
        colour = _COLOURS[index % len(_COLOURS)]
        check = check_curve(polar, case)
        speed = np.linspace(_stall_speed(polar, case), 15.0, 200)
        label = f"{polar.airfoil}, calibration {polar.calibration:.2f} (RMS {check.rms_w:.1f} W)"
        dashes, marker = _LINES[index % len(_LINES)], _MARKERS[index % len(_MARKERS)]
        power = case.electric_power_w(polar, speed)
        axes.plot(speed, power, color=colour, linestyle=dashes, label=label)
        residual_axes.plot(
            check.airspeed_m_per_s,
            check.residual_w,
            marker=marker,
            linestyle=dashes,
            color=colour,
            markersize=3.5,
            linewidth=1,
        )
    axes.plot(
        flight[:, 0], flight[:, 1], "o", color=ink(), markersize=4, label="flight, means over 200 s"
    )
    axes.set(ylabel="electric power [W]", ylim=(0, None))
    axes.legend(loc="upper left")
    residual_axes.axhline(0.0, color=ink(), linewidth=1)
    residual_axes.set(xlabel="airspeed [m/s]", ylabel="model − flight [W]")
    return drawn


def _stall_speed(polar: WingPolar, case: PowerCase) -> float:
    highest, loading = polar.maximum_lift_coefficient, case.mass_kg / case.wing_area_m2
    return float(level_airspeed_m_per_s(highest, loading, case.density_kg_per_m3))


def power_curve_image(image_format: str = "png", figure: FigureOptions = DEFAULT) -> bytes:
    """Image of AS-1's power with every shipped airfoil, calibrated with AS-2's one number.

    Parameters
    ----------
    image_format : str
        One of :data:`studies.output.formats.IMAGE_FORMATS`.
    figure : FigureOptions
        How it looks.

    Returns
    -------
    bytes
    """
    polars = [
        wing_polar(check.airfoil, AS1, calibration=check.calibration)
        for check in check_level_flight()
    ]
    return to_bytes(power_curve_figure(polars, figure=figure), image_format)


def power_tables() -> tuple[Table, Table]:
    """Level flight of AS-2 with every airfoil, and the power curve of AS-1 beside its flight."""
    checks = check_level_flight()
    level = [
        (
            check.airfoil,
            check.lift_coefficient,
            check.airspeed_m_per_s,
            check.electric_power_w,
            100.0 * (check.electric_power_w / AS2_POWER_W - 1.0),
            check.calibration,
        )
        for check in checks
    ]
    curves = []
    for airfoil, *_, calibrated in level:
        check = check_curve(wing_polar(airfoil, AS1, calibration=calibrated))
        residuals = " ".join(f"{value:+.1f}" for value in check.residual_w)
        curves.append((airfoil, calibrated, check.bias_w, check.rms_w, residuals))
    airfoil_column, calibration_column = Column("airfoil"), Column("calibration", form=".2f")
    return (
        Table(
            AS2.name,
            (
                airfoil_column,
                Column("lift_coefficient", "C_L", form=".2f"),
                Column("airspeed_m_per_s", "airspeed", "m/s", ".1f"),
                Column("electric_power_w", "power", "W", ".1f"),
                Column("against", f"against {AS2_POWER_W:g} W", form="{:+.0f} %"),
                calibration_column,
            ),
            tuple(level),
        ),
        Table(
            AS1.name,
            (
                airfoil_column,
                calibration_column,
                Column("bias_w", "bias", "W", "+.1f"),
                Column("rms_w", "RMS", "W", ".1f"),
                Column("residuals_w", "residuals [W], slow to fast"),
            ),
            tuple(curves),
        ),
    )


def main(arguments: list[str] | None = None) -> int:
    """Command line: write the figure; the exit code is 1 where it cannot."""
    prog = "python -m benchmarks.validation.power_curve"
    return write_figure(power_curve_image, arguments, prog=prog, description=__doc__)


if __name__ == "__main__":
    raise SystemExit(main())
