"""Loss chain of a day: from the light on the modules to the load, each loss with its cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from missions.mission import Scenarios
from sizing.day.light import SolarModel, solar_day
from sizing.results.analysis import Analysis
from studies.render.numbers import percent

LIGHT, ELECTRIC, LOAD = (
    "light on a horizontal area as large as the modules",
    "electric energy of the modules",
    "load",
)
SUMS = frozenset((LIGHT, ELECTRIC, LOAD))  # steps that say where the chain has arrived
_SHOWN_WH = 0.5  # smaller losses are left out


def loss_chain(analysis: Analysis) -> tuple[tuple[str, float], ...]:
    """Return the steps from the light on the modules to the load, in the worst scenario [Wh].

    A step is a loss, negative, or one of :data:`SUMS`. The losses of the modules are found by the
    solar power model itself, with one loss after the other taken away. Of a flight that draws from
    a full battery, what it draws is a step as well.
    """
    cycle, worst = analysis.performance.cycle, analysis.worst
    budget = {
        key.removesuffix("_wh"): float(np.broadcast_to(values, cycle.status.shape)[worst])
        for key, values in vars(cycle.energy_budget).items()
    }
    solar_wh, stored_wh = budget["solar"], budget["stored"]
    steps = [
        *(_of_modules(analysis, solar_wh) if solar_wh > 0.0 else ()),
        (ELECTRIC, solar_wh),
        ("not collected, the battery being full", -budget["curtailed"]),
        ("lost in charging", -budget["charge_loss"]),
        ("lost in discharging", -budget["discharge_loss"]),
        ("left in the battery" if stored_wh > 0.0 else "drawn from the battery", -stored_wh),
        (LOAD, budget["load"]),
        ("of which not met: the battery is empty", -budget["unserved"]),
    ]
    return tuple((label, wh) for label, wh in steps if label in SUMS or abs(wh) >= _SHOWN_WH)


def _of_modules(analysis: Analysis, solar_wh: float) -> list[tuple[str, float]]:
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
    labels = (
        f"not converted: module efficiency {percent(modules.efficiency_stc)}",
        f"angle of incidence, diffuse light, attitude{', MPPT' if solar.model == 'FM' else ''}",
        "camber of the wing",
        "temperature of the modules",
        "MPPT",
        "correction of the model's systematic error",
    )
    losses = np.diff([light, light * modules.efficiency_stc, *by_model]).tolist()
    return [(LIGHT, float(light)), *zip(labels, losses, strict=True)]


def _energy(analysis: Analysis, model: SolarModel, changes: dict[str, float]) -> float:
    """Return the energy of a day by a model with changed modules, in proportion to others."""
    perf, worst = analysis.performance, analysis.worst
    modules = analysis.aircraft.modules.model_copy(update=changes)
    aircraft = analysis.aircraft.model_copy(update={"modules": modules})
    of = perf.day.scenarios
    scenarios = Scenarios(of.latitude_deg[[worst]], of.day_of_year[[worst]])
    day = solar_day(aircraft, analysis.mission, model, scenarios=scenarios, design=perf.design)
    return float(np.trapezoid(day.specific_power_w_per_m2[0], day.time_h))
