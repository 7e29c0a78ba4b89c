"""
Propulsion of a twin-boom aircraft
==================================

Which propeller and motor suit it at which voltage, and what one geared motor costs instead of two.

Run with: ``python examples/twin_boom_propulsion.py [figure.png]``
"""

import dataclasses
import sys

import matplotlib.pyplot as plt
import numpy as np

import missions
import sizing

NAME, MISSION = "twin-boom-design", "rafz-july"
DIAMETERS_M, SPEED_CONSTANTS = np.linspace(0.28, 0.64, 13), np.linspace(150.0, 510.0, 13)
# One motor in the nose: that of the example in docs/propulsion.md, with AtlantikSolar's propeller.
ONE_MOTOR = {
    "airframe.propulsion.propulsors": 1,
    "airframe.propulsion.propeller": {"diameter_m": 0.66, "pitch_m": 0.60, "mass_kg": 0.05},
    "airframe.propulsion.gear": {"ratio": 5, "efficiency": 0.96, "mass_kg": 0.06},
    "airframe.propulsion.motor": "maxon-re40-148867",
    "airframe.drag.pods": [{"length_m": 0.9, "diameter_m": 0.13}],
}


def chain_efficiency(analysis: sizing.Analysis, voltages_v: list[float]) -> np.ndarray:
    """Efficiency over voltage, speed constant and diameter; NaN where it cannot fly level."""
    propulsion, air = analysis.aircraft.airframe.propulsion, analysis.mission.air_state()
    airspeed = analysis.airspeed_m_per_s
    thrust_n = analysis.power_budget.watts["aerodynamic_w"] / airspeed / propulsion.propulsors
    shape = (len(voltages_v), len(SPEED_CONSTANTS), len(DIAMETERS_M))
    efficiency_of_chain, propulsor = np.full(shape, np.nan), propulsion.propulsor
    for column, diameter_m in enumerate(DIAMETERS_M):
        # Pitch as large as the diameter, as the file has it.
        propeller = sizing.BladeElementPropeller(
            diameter_m=float(diameter_m), pitch_m=float(diameter_m), blades=2
        )
        for row, speed_constant in enumerate(SPEED_CONSTANTS):
            motor = propulsor.motor.rewound(float(speed_constant))
            motor = motor.model_copy(update={"maximum_current_a": None})
            varied = dataclasses.replace(propulsor, propeller=propeller, motor=motor)
            point = sizing.operating_point(varied, thrust_n, airspeed, air, np.array(voltages_v))
            efficiency_of_chain[:, row, column] = point.efficiency
    return efficiency_of_chain


def main() -> None:
    """Print and draw the efficiency of the chain; compare two motors with one."""
    mission = missions.load_mission(MISSION)
    twin = sizing.analyse(sizing.load_aircraft(NAME), mission)
    voltages_v = [float(v) for v in twin.aircraft.battery.voltage.voltage_v([0.0, 0.5, 1.0])]
    efficiency = chain_efficiency(twin, voltages_v)
    for voltage, panel in zip(voltages_v, efficiency, strict=True):
        row, column = np.unravel_index(np.nanargmax(panel), panel.shape)
        print(
            f"{voltage:.1f} V: at best {np.nanmax(panel):.3f} with {DIAMETERS_M[column]:.2f} m and "
            f"{SPEED_CONSTANTS[row]:.0f} rpm/V; {np.isnan(panel).mean():.0%} cannot fly level"
        )
    single = sizing.analyse(sizing.load_aircraft(NAME, ONE_MOTOR), mission)
    for text, analysis in (("two motors", twin), ("one geared motor", single)):
        chain = analysis.power_budget.efficiencies["chain"]
        propulsion_kg = analysis.masses_kg["propulsion"]
        print(
            f"{text}: {analysis.total_mass_kg:.2f} kg, propulsion {propulsion_kg:.2f} "
            f"kg, chain {chain:.3f}, load {analysis.power_out_w:.1f} W, "
            f"excess time {analysis.excess_time_h:.2f} h"
        )
    if len(sys.argv) > 1:
        draw(voltages_v, efficiency, sys.argv[1])


def draw(voltages_v: list[float], efficiency: np.ndarray, path: str) -> None:
    """Draw a panel for each voltage; grey: the voltage does not suffice."""
    figure, panels = plt.subplots(1, 3, figsize=(10, 3.6), sharey=True, layout="constrained")
    levels = np.arange(0.44, 0.611, 0.01)
    for axes, voltage, panel in zip(panels, voltages_v, efficiency, strict=True):
        axes.set_facecolor("0.85")
        filled = axes.contourf(DIAMETERS_M, SPEED_CONSTANTS, panel, levels, extend="min")
        axes.set(title=f"{voltage:.1f} V", xlabel="propeller diameter = pitch [m]")
        axes.plot(0.46, 300, "k+", markersize=10)
    panels[0].set_ylabel("speed constant [rpm/V], gear 3:1")
    figure.colorbar(filled, ax=panels, label="efficiency, battery to thrust [-]")
    figure.suptitle(f"{NAME} on {MISSION}: two motors; grey: no level flight; +: the file")
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
