"""The report's comparison of CDM, CAM, VM and FM with flight, regenerated from first principles.

AtlantikSolar AS-2 flies the morning of 1 July 2015 on a circle in an easterly wind of 2 m/s. What
the report does not publish (radius, airspeed, pitch, mean temperature) is assumed, once for all
numbers, in the shipped mission ``rafz-loiter``; :func:`sensitivities` shows what each assumption is
worth. Source of the published values: Oettershagen, "High-Fidelity Solar Power Income Modeling for
Solar-Electric UAVs", table 3 and section 4.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from missions.flight_path import Circle
from missions.library import load_mission
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.library import load_aircraft
from sizing.sunlight import modelled_power
from solar.names import MODEL_NAMES, ModelName
from solar.types import FloatArray

AIRCRAFT, MISSION = "atlantiksolar-as2", "rafz-loiter"
MEASURED_W = 99.61
PUBLISHED_W: dict[ModelName, float] = {"CDM": 117.35, "CAM": 104.89, "VM": 97.65, "FM": 97.87}
PERIOD_H = (4.17, 9.72)
_STEP_H = 1.0 / 120.0
_COLOURS = {"CDM": "#E69F00", "CAM": "#56B4E9", "VM": "#009E73", "FM": "#D55E00"}


@dataclass(frozen=True)
class Window:
    """A detail window of the report: Full Model and flight, means over solar time."""

    from_h: float
    to_h: float
    published_w: float
    measured_w: float


WINDOWS = (
    Window(5.71, 5.79, 35.3, 33.6),
    Window(8.02, 8.12, 140.5, 142.1),
    Window(9.52, 9.62, 204.7, 211.5),
)


@dataclass(frozen=True)
class Reproduction:
    """Computed means: of every model over the whole period, of the Full Model in each window."""

    models_w: dict[ModelName, float]
    windows_w: tuple[float, ...]


@dataclass(frozen=True)
class Sensitivity:
    """What one changed assumption makes of every number."""

    assumption: str
    value: str
    result: Reproduction


def reference() -> tuple[Aircraft, Mission]:
    """Aircraft and mission with the stated assumptions."""
    return load_aircraft(AIRCRAFT), load_mission(MISSION)


def power_w(aircraft: Aircraft, mission: Mission, model: ModelName, time_h: FloatArray) -> Any:
    """Solar power of a model over solar time on the mission's (single) day [W]."""
    scenarios: Scenarios = mission.scenarios()
    return aircraft.modules.area_m2 * modelled_power(aircraft, mission, model, scenarios, time_h)[0]


def reproduce(aircraft: Aircraft, mission: Mission) -> Reproduction:
    """Means of all models over the report's period and of FM in its windows."""
    period = _axis(*PERIOD_H)
    models = {m: _mean(power_w(aircraft, mission, m, period), period) for m in MODEL_NAMES}
    windows = []
    for window in WINDOWS:
        time_h = _axis(window.from_h, window.to_h)
        windows.append(_mean(power_w(aircraft, mission, "FM", time_h), time_h))
    return Reproduction(models, tuple(windows))


def sensitivities(aircraft: Aircraft, mission: Mission) -> list[Sensitivity]:
    """Reproductions with one assumption changed at a time."""
    path = mission.flight_path
    assert isinstance(path, Circle)
    air_c = mission.air.ambient_temperature_c
    assert air_c is not None

    def with_path(**change: float | str) -> Mission:
        return mission.model_copy(update={"flight_path": path.model_copy(update=change)})

    def with_air(celsius: float) -> Mission:
        update = {"ambient_temperature_c": celsius, "module_temperature_c": celsius}
        return mission.model_copy(update={"air": mission.air.model_copy(update=update)})

    cases: list[tuple[str, str, Mission]] = [
        *(
            ("wind from east", f"{w:g} m/s", mission.model_copy(update={"wind_m_per_s": w}))
            for w in (0.0, 1.0, 3.0)
        ),
        *(
            ("2 m/s wind from", name, mission.model_copy(update={"wind_from_deg": degrees}))
            for name, degrees in (("north", 0.0), ("south", 180.0), ("west", 270.0))
        ),
        *(("radius", f"{r:g} m", with_path(radius_m=r)) for r in (50.0, 200.0)),
        *(("airspeed", f"{v:g} m/s", with_path(airspeed_m_per_s=v)) for v in (8.0, 10.0)),
        *(("pitch", f"{p:+g} deg", with_path(pitch_deg=p)) for p in (-3.0, 3.0)),
        *(("turns", d, with_path(direction=d)) for d in ("clockwise", "counterclockwise")),
        *(("temperature", f"{air_c + d:g} C", with_air(air_c + d)) for d in (-5.0, 5.0)),
    ]
    return [Sensitivity(a, v, reproduce(aircraft, changed)) for a, v, changed in cases]


def assumptions(mission: Mission) -> dict[str, Any]:
    """Everything that the computed numbers rest on, JSON-ready."""
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


def to_json(result: Reproduction, mission: Mission, varied: list[Sensitivity]) -> dict[str, Any]:
    """Published and computed numbers, JSON-ready."""
    return {
        "models": {
            m: {"published_w": PUBLISHED_W[m], "computed_w": result.models_w[m]}
            for m in MODEL_NAMES
        },
        "measured_w": MEASURED_W,
        "windows": [
            {
                "from_h": w.from_h,
                "to_h": w.to_h,
                "published_w": w.published_w,
                "measured_w": w.measured_w,
                "computed_w": computed,
            }
            for w, computed in zip(WINDOWS, result.windows_w, strict=True)
        ],
        "assumptions": assumptions(mission),
        "sensitivities": [
            {
                "assumption": s.assumption,
                "value": s.value,
                "models_w": s.result.models_w,
                "windows_w": list(s.result.windows_w),
            }
            for s in varied
        ],
    }


def markdown(result: Reproduction, varied: list[Sensitivity]) -> str:
    """Two tables: published against computed, and what each assumption is worth."""
    lines = [
        "| mean power | published [W] | computed [W] | difference [%] |",
        "|---|---|---|---|",
    ]
    rows = [(f"{m}, 4.17 to 9.72 h", PUBLISHED_W[m], result.models_w[m]) for m in MODEL_NAMES]
    rows += [
        (f"FM, {w.from_h:g} to {w.to_h:g} h", w.published_w, c)
        for w, c in zip(WINDOWS, result.windows_w, strict=True)
    ]
    lines += [f"| {n} | {p:.2f} | {c:.2f} | {100 * (c / p - 1):+.1f} |" for n, p, c in rows]
    heads = [*MODEL_NAMES, *(f"FM {w.from_h:g} h" for w in WINDOWS)]
    lines += ["", "| assumption | " + " | ".join(f"{h} [W]" for h in heads) + " |"]
    lines += ["|---" * (len(heads) + 1) + "|"]
    for name, values in [("as stated", _numbers(result))] + [
        (f"{s.assumption} {s.value}", _numbers(s.result)) for s in varied
    ]:
        lines.append(f"| {name} | " + " | ".join(f"{v:.1f}" for v in values) + " |")
    return "\n".join(lines) + "\n"


def figure(aircraft: Aircraft, mission: Mission) -> Figure:
    """All models over solar time, with the report's windows and the flight's means in them."""
    time_h = _axis(4.0, 10.0)
    canvas = Figure(figsize=(8.0, 4.8), layout="constrained")
    axes = canvas.subplots()
    for model, dashes in zip(MODEL_NAMES, (":", "-.", "--", "-"), strict=True):
        power = power_w(aircraft, mission, model, time_h)
        axes.plot(time_h, power, color=_COLOURS[model], linestyle=dashes, label=model)
    for window in WINDOWS:
        axes.axvspan(window.from_h, window.to_h, color="#DDDDDD", zorder=0, linewidth=0)
        middle = (window.from_h + window.to_h) / 2.0
        last = window is WINDOWS[-1]
        axes.plot(
            [middle],
            [window.measured_w],
            "k_",
            markersize=12,
            markeredgewidth=2,
            label="flight, mean of a window" if last else None,
        )
    axes.set(
        xlabel="solar time [h]",
        ylabel="solar power [W]",
        xlim=(4, 10),
        ylim=(0, None),
        title=f"{aircraft.name}, 1 July, 47.6 N, loiter in {mission.wind_m_per_s:g} m/s of "
        "easterly wind (uncorrected)",
    )
    axes.grid(alpha=0.3)
    axes.legend()
    return canvas


def _axis(start_h: float, end_h: float) -> FloatArray:
    return np.linspace(start_h, end_h, int(np.ceil((end_h - start_h) / _STEP_H)) + 1)


def _mean(power: FloatArray, time_h: FloatArray) -> float:
    return float(np.trapezoid(power, time_h) / (time_h[-1] - time_h[0]))


def _numbers(result: Reproduction) -> list[float]:
    return [*result.models_w.values(), *result.windows_w]
