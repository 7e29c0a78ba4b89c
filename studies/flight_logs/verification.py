"""Solar power models against a flight log: errors, and what looks wrong in the flight.

The errors are those of :mod:`studies.flight_logs.errors`; the anomalies are sought by the rules of
:mod:`studies.flight_logs.limited_charging` and :mod:`studies.flight_logs.anomalies`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from missions.files.errors import file_error
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.types import BoolArray
from studies.flight_logs.anomalies import other_anomalies
from studies.flight_logs.errors import Section, Window, day_masks, in_window, sections, solar_span
from studies.flight_logs.limited_charging import battery_full
from studies.flight_logs.log_view import Anomaly, Scene
from studies.flight_logs.samples import (
    Samples,
    ShadedArea,
    lit_samples,
    module_geometry,
    tail_shading,
)

WINDOW_SEMI, DAY_SEMI = 2, 800  # samples; the report's filters


@dataclass(frozen=True)
class Verification:
    """Everything that a verification found."""

    aircraft: str
    mission: str
    log: FlightLog
    samples: Samples
    excluded: BoolArray
    windows: tuple[Section, ...]
    window_masks: tuple[BoolArray, ...]
    days: tuple[Section, ...]
    day_semi: int
    window_semi: int
    anomalies: tuple[Anomaly, ...]
    notes: tuple[str, ...]


def verify(
    log: FlightLog,
    aircraft: Aircraft,
    mission: Mission,
    *,
    windows: Sequence[Window] = (),
    semi_window: int | None = None,
    shading: ShadedArea | None = None,
) -> Verification:
    """Compare all models with a log and look for anomalies.

    Parameters
    ----------
    log : FlightLog
        The flight.
    aircraft : Aircraft
        Its modules; VM and FM need their geometry.
    mission : Mission
        Clearness, and temperatures that the log does not have.
    windows : sequence of Window
        Periods to report on apart from the days.
    semi_window : int, optional
        Samples on either side in the moving average; 2 in windows and 800 over days if not given.
    shading : ShadedArea, optional
        Shaded area instead of that of the aircraft's own tail.

    Raises
    ------
    InputError
        If the sun never rises in the log, or a window has no sample.
    """
    geometry, reasons = module_geometry(log, aircraft)
    shade = shading
    if shade is None and geometry is not None:
        shade, reason = tail_shading(aircraft, geometry)
        reasons += [reason] if reason else []
    samples, sources = lit_samples(log, aircraft, mission, geometry, shade)
    scene = Scene.of(log, samples, aircraft)
    full, limited = battery_full(scene)
    found = [*full, *other_anomalies(scene, limited)]
    masks = tuple(in_window(samples, window) for window in windows)
    for window, mask in zip(windows, masks, strict=True):
        if not mask.any():
            message = f"no sample with the sun up lies in the window {window.label} (solar time)"
            raise file_error(log.source, f"{message}; allowed: {solar_span(samples)}")
    window_semi = WINDOW_SEMI if semi_window is None else semi_window
    day_semi = DAY_SEMI if semi_window is None else semi_window
    return Verification(
        aircraft=aircraft.name,
        mission=mission.name,
        log=log,
        samples=samples,
        excluded=limited,
        windows=sections(
            samples, limited, window_semi, zip([w.label for w in windows], masks, strict=True)
        ),
        window_masks=masks,
        days=sections(samples, limited, day_semi, day_masks(samples)),
        day_semi=day_semi,
        window_semi=window_semi,
        anomalies=tuple(sorted(found, key=lambda a: (a.start_s, a.kind))),
        notes=(*log.notes, *reasons, *sources),
    )
