"""Loss chain of a day: from the light on the modules to the load, each loss with its cause."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from missions.mission import Scenarios
from sizing.day.light import SolarModel, solar_day
from sizing.results.analysis import Analysis

LIGHT = "light on a horizontal area as large as the modules"
_SHOWN_WH = 0.5  # smaller losses are left out


@dataclass(frozen=True)
class Step:
    """Step of a loss chain [Wh]: a loss, negative, or the sum at which the chain has arrived."""

    label: str
    energy_wh: float
    is_sum: bool = False


def loss_chain(analysis: Analysis) -> tuple[Step, ...]:
    """Return the steps from the light on the modules to the load, in the worst scenario.

    The losses of the modules are found by the solar power model itself, with one loss after the
    other taken away. Of a flight that draws from a full battery, what it draws is a step as well.
    """
    budget, worst = analysis.performance.cycle.energy_budget, analysis.worst
    solar_wh, load_wh, charging_wh, discharging_wh, unused_wh, stored_wh, unserved_wh = (
        float(np.broadcast_to(values, analysis.performance.cycle.status.shape)[worst])
        for values in (
            budget.solar_wh,
            budget.load_wh,
            budget.charge_loss_wh,
            budget.discharge_loss_wh,
            budget.curtailed_wh,
            budget.stored_wh,
            budget.unserved_wh,
        )
    )
    steps = [
        *(_of_modules(analysis, solar_wh) if solar_wh > 0.0 else ()),
        Step("electric energy of the modules", solar_wh, is_sum=True),
        Step("not collected, the battery being full", -unused_wh),
        Step("lost in charging", -charging_wh),
        Step("lost in discharging", -discharging_wh),
        Step("left in the battery" if stored_wh > 0.0 else "drawn from the battery", -stored_wh),
        Step("load", load_wh, is_sum=True),
        Step("of which not met: the battery is empty", -unserved_wh),
    ]
    return tuple(step for step in steps if step.is_sum or abs(step.energy_wh) >= _SHOWN_WH)


def _of_modules(analysis: Analysis, solar_wh: float) -> tuple[Step, ...]:
    """Return the steps from the light to the electric energy of the modules."""
    solar, modules = analysis.performance.solar, analysis.aircraft.modules
    uncorrected = replace(solar, correction="none")
    ideal = {"mppt_efficiency": 1.0}
    cool = ideal | {"temperature_coefficient_per_k": 0.0}
    flat = cool | {"camber_efficiency": 1.0}
    cases: tuple[tuple[SolarModel, dict[str, float]], ...] = (
        (SolarModel("CDM"), flat | {"efficiency_stc": 1.0}),
        (uncorrected, flat),
        (uncorrected, cool),
        (uncorrected, ideal),
        (uncorrected, {}),
        (solar, {}),
    )
    each = np.array([_energy(analysis, model, changes) for model, changes in cases])
    light, *by_model = solar_wh / each[-1] * each
    converted = light * modules.efficiency_stc
    levels = (light, converted, *by_model)
    labels = (
        f"not converted: module efficiency {100.0 * modules.efficiency_stc:.1f} %",
        f"angle of incidence, diffuse light, attitude{', MPPT' if solar.model == 'FM' else ''}",
        "camber of the wing",
        "temperature of the modules",
        "MPPT",
        "correction of the model's systematic error",
    )
    losses = zip(labels, np.diff(levels), strict=True)
    return (
        Step(LIGHT, float(light), is_sum=True),
        *(Step(label, float(change)) for label, change in losses),
    )


def _energy(analysis: Analysis, model: SolarModel, changes: dict[str, float]) -> float:
    """Return the energy of a day by a model with changed modules, in proportion to others."""
    perf, worst = analysis.performance, analysis.worst
    modules = analysis.aircraft.modules.model_copy(update=changes)
    aircraft = analysis.aircraft.model_copy(update={"modules": modules})
    of = perf.day.scenarios
    scenarios = Scenarios(of.latitude_deg[[worst]], of.day_of_year[[worst]])
    day = solar_day(aircraft, analysis.mission, model, scenarios=scenarios, design=perf.design)
    return float(np.trapezoid(day.specific_power_w_per_m2[0], day.time_h))
