"""Reproduction of the report's comparison of CDM, CAM, VM and FM with flight.

AtlantikSolar AS-2 flies the morning of 1 July 2015 on a circle in an easterly wind of 2 m/s.
Unpublished radius, airspeed, pitch and mean temperature are assumed, once for all numbers, in the
shipped mission ``rafz-loiter``; with ``vary``, :func:`reproduce` shows the effect of each. Source
of the published values: Oettershagen, "High-Fidelity Solar Power Income Modeling for Solar-Electric
UAVs", table 3 and section 4.1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from missions.library import load_mission
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.module_power import modelled_power, surroundings_in_flight
from sizing.library import load_aircraft
from sizing.parameters import all_replaced
from sizing.results.result import Result
from solar.names import MODEL_NAMES, ModelName
from solar.schema import spell
from solar.types import FloatArray
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT
from studies.quantities import group
from studies.render.tables import Column, Line, Table
from studies.render.words import percent

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

AIRCRAFT, MISSION = "atlantiksolar-as2", "rafz-loiter"
MEASURED_W = 99.61
PUBLISHED_W: dict[ModelName, float] = {"CDM": 117.35, "CAM": 104.89, "VM": 97.65, "FM": 97.87}
PERIOD_H = (4.17, 9.72)
_STEP_H = 1.0 / 120.0


class Window(NamedTuple):
    """Time window of the report: means of Full Model and flight."""

    from_h: float
    to_h: float
    published_w: float
    measured_w: float


WINDOWS = (
    Window(5.71, 5.79, 35.3, 33.6),
    Window(8.02, 8.12, 140.5, 142.1),
    Window(9.52, 9.62, 204.7, 211.5),
)


@dataclass(frozen=True, repr=False)
class Reproduction(Result):
    """Computed mean powers against the report's.

    ``aircraft``, ``mission``: of the flight, with the assumptions. ``models_w``: mean of every
    model over the whole period [W]. ``windows_w``: mean of the Full Model in each window [W].
    ``varied``: results with one assumption changed at a time, by its name and value.
    """

    aircraft: Aircraft
    mission: Mission
    models_w: dict[ModelName, float]
    windows_w: tuple[float, ...]
    varied: Mapping[tuple[str, str], Reproduction] = field(default_factory=dict)

    def tables(self) -> tuple[Table, ...]:
        """Return published against computed means and, if requested, varied assumptions."""
        period = f"{spell(PERIOD_H[0])} to {spell(PERIOD_H[1])} h"
        means = [(f"{m}, {period}", PUBLISHED_W[m], MEASURED_W) for m in MODEL_NAMES]
        means += [
            (f"FM, {spell(w.from_h)} to {spell(w.to_h)} h", w.published_w, w.measured_w)
            for w in WINDOWS
        ]
        columns = group("mean_power published_w computed_w difference_percent flight_w")
        rows = tuple(
            (name, published, computed, 100.0 * (computed / published - 1.0), flight)
            for (name, published, flight), computed in zip(means, self._means_w(), strict=True)
        )
        title = "mean solar power, published and computed"
        power = Table(title, columns, rows, sections=(len(MODEL_NAMES),))
        if not self.varied:
            return (power,)
        heads = [*MODEL_NAMES, *(f"FM {spell(w.from_h)} h" for w in WINDOWS)]
        return power, Table(
            "one assumption changed at a time",
            (Column("assumption"), *(Column(head, unit="W", form=".1f") for head in heads)),
            (
                ("as stated", *self._means_w()),
                *((" ".join(changed), *r._means_w()) for changed, r in self.varied.items()),
            ),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return published and computed numbers, JSON-ready."""
        return {
            "models": {
                m: {"published_w": PUBLISHED_W[m], "computed_w": self.models_w[m]}
                for m in MODEL_NAMES
            },
            "measured_w": MEASURED_W,
            "windows": [
                window._asdict() | {"computed_w": computed}
                for window, computed in zip(WINDOWS, self.windows_w, strict=True)
            ],
            "assumptions": assumptions(self.mission),
            "sensitivities": [
                {
                    "assumption": assumption,
                    "value": value,
                    "models_w": result.models_w,
                    "windows_w": list(result.windows_w),
                }
                for (assumption, value), result in self.varied.items()
            ],
        }

    def to_frame(self) -> pd.DataFrame:
        """Return published and computed means, one row each."""
        return self.tables()[0].to_frame()

    def _means_w(self) -> list[float]:
        return [*self.models_w.values(), *self.windows_w]


def headline(reproduction: Reproduction) -> str:
    """Return the largest difference from the report."""
    published = [*PUBLISHED_W.values(), *(w.published_w for w in WINDOWS)]
    pairs = zip(reproduction._means_w(), published, strict=True)
    worst = max((computed / p - 1.0 for computed, p in pairs), key=abs)
    subject = f"{reproduction.aircraft.name} on {reproduction.mission.name}"
    return f"{subject}: means of power within {percent(abs(worst))} of the report's"


def blocks(reproduction: Reproduction, level: int) -> list[Any]:
    """Return the tables and the assumptions, at every level."""
    inputs = assumptions(reproduction.mission)
    known = inputs | inputs["flight_path"]
    numbers = {name: spell(value) for name, value in known.items() if isinstance(value, float)}
    assumed = (
        "Assumed: {kind} of {radius_m} m at {airspeed_m_per_s} m/s, pitch {pitch_deg} deg, wind "
        "{wind_m_per_s} m/s from {wind_from_deg} deg, air {ambient_temperature_c} C."
    ).format(**known | numbers)
    return [Line(headline(reproduction), "strong"), *reproduction.tables(), Line(assumed, "faint")]


def reference() -> tuple[Aircraft, Mission]:
    """Load aircraft and mission with the stated assumptions."""
    return load_aircraft(AIRCRAFT), load_mission(MISSION)


def power_w(aircraft: Aircraft, mission: Mission, model: ModelName, time_h: FloatArray) -> Any:
    """Compute the solar power of a model on the mission's (single) day [W]."""
    scenarios: Scenarios = mission.scenarios()
    around = surroundings_in_flight(aircraft, mission)
    power = modelled_power(aircraft, mission, model, scenarios, time_h, around)
    return aircraft.modules.area_m2 * power[0]


def reproduce(aircraft: Aircraft, mission: Mission, *, vary: bool = False) -> Reproduction:
    """Compute means of all models over the report's period and of FM in its windows.

    ``vary``: repeat with one assumption changed at a time.
    """
    period = _time_axis_h(*PERIOD_H)
    models = {m: _mean(power_w(aircraft, mission, m, period), period) for m in MODEL_NAMES}
    windows = []
    for window in WINDOWS:
        time_h = _time_axis_h(window.from_h, window.to_h)
        windows.append(_mean(power_w(aircraft, mission, "FM", time_h), time_h))
    varied = {
        (name, value): reproduce(aircraft, changed)
        for name, value, changed in (_variations(mission) if vary else ())
    }
    return Reproduction(aircraft, mission, models, tuple(windows), varied)


def _variations(mission: Mission) -> list[tuple[str, str, Mission]]:
    """Return missions with one assumption changed: its name, its value, the mission."""
    air_c = mission.air.ambient_temperature_c
    assert air_c is not None
    path, air = "flight_path", ("air.ambient_temperature_c", "air.module_temperature_c")
    changes: list[tuple[str, str, dict[str, Any]]] = [
        *(("wind from east", f"{spell(w)} m/s", {"wind_m_per_s": w}) for w in (0.0, 1.0, 3.0)),
        *(
            ("2 m/s wind from", name, {"wind_from_deg": degrees})
            for name, degrees in (("north", 0.0), ("south", 180.0), ("west", 270.0))
        ),
        *(("radius", f"{spell(r)} m", {f"{path}.radius_m": r}) for r in (50.0, 200.0)),
        *(("airspeed", f"{spell(v)} m/s", {f"{path}.airspeed_m_per_s": v}) for v in (8.0, 10.0)),
        *(("pitch", f"{p:+g} deg", {f"{path}.pitch_deg": p}) for p in (-3.0, 3.0)),
        *(("turns", d, {f"{path}.direction": d}) for d in ("clockwise", "counterclockwise")),
        *(("temperature", f"{spell(c)} C", dict.fromkeys(air, c)) for c in (air_c - 5, air_c + 5)),
    ]
    return [(name, value, all_replaced(mission, changed)) for name, value, changed in changes]


def assumptions(mission: Mission) -> dict[str, Any]:
    """Return all assumptions of the computed numbers, JSON-ready."""
    path = mission.flight_path
    assert path is not None
    return {
        "latitude_deg": mission.latitudes()[0],
        "day_of_year": mission.dates.days()[0],
        "altitude_m": mission.altitude_m,
        "ambient_temperature_c": mission.air.ambient_temperature_c,
        "module_temperature_c": mission.module_temperature_c(),
        "clearness": mission.clearness,
        "wind_m_per_s": mission.wind_m_per_s,
        "wind_from_deg": mission.wind_from_deg,
        "flight_path": path.model_dump(),
    }


@drawing.styled
def reproduction_figure(result: Reproduction, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw all models over solar time, with the report's windows and the flight's means."""
    aircraft, mission, time_h = result.aircraft, result.mission, _time_axis_h(4.0, 10.0)
    wind = f"loiter in {spell(mission.wind_m_per_s)} m/s of easterly wind"
    drawn, (axes,) = drawing.new_figure(
        canvas=figure,
        title=f"{aircraft.name} on {mission.name}, 47.6° N, 1 Jul",
        notes=("all models, uncorrected", wind),
    )
    for model in MODEL_NAMES:
        power = power_w(aircraft, mission, model, time_h)
        axes.plot(time_h, power, label=model, **drawing.MODEL_LOOKS[model])
    drawing.shade(axes, [(window.from_h, window.to_h) for window in WINDOWS])
    axes.plot(
        [(window.from_h + window.to_h) / 2.0 for window in WINDOWS],
        [window.measured_w for window in WINDOWS],
        "_",
        color=drawing.ink(),
        markersize=12,
        markeredgewidth=2,
        label="flight, mean of a window",
    )
    axes.set(xlabel="solar time [h]", ylabel="solar power [W]", xlim=(4, 10), ylim=(0, None))
    axes.legend()
    return drawn


def _time_axis_h(start_h: float, end_h: float) -> FloatArray:
    return np.linspace(start_h, end_h, int(np.ceil((end_h - start_h) / _STEP_H)) + 1)


def _mean(power: FloatArray, time_h: FloatArray) -> float:
    return float(np.trapezoid(power, time_h) / (time_h[-1] - time_h[0]))
