"""Explorer without a server: from the settings of a page to its day curve, map, sizing and files.

What is computed is what the command line computes: settings become files of an aircraft and a
mission, as ``--set`` would change them, and these are analysed and sized.

Light of a map does not depend on the design: it is computed once for each technology of modules,
air and solar power model, and multiplied by the module area. Models that follow the flight path
take milliseconds for each cell; their map is filled a few latitudes at a time.
"""

from __future__ import annotations

import re
import shlex
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import lru_cache
from math import isfinite
from typing import Any

import numpy as np

from missions.dates import date_code
from missions.files.errors import InputError
from missions.files.writing import file_text, names_a_device
from missions.mission import Scenarios
from sizing.aircraft import MeasuredAirframe
from sizing.day.light import DEFAULT_STEP_H, SolarDay, SolarModel, solar_day
from sizing.design import Design
from sizing.mass_budget import ImpossibleDesignError
from sizing.parameters import MISSION_PREFIX
from sizing.performance import performance
from sizing.program.objectives import SINGLE_OBJECTIVES
from sizing.results.analysis import Analysis, analyse
from sizing.results.result import finite
from solar._version import __version__
from solar.schema import significant, spell
from solar.types import FloatArray
from studies.case import Case
from studies.explorer.fields import ALTITUDE, DAY, LATITUDE, Choice, Field, fields_of
from studies.explorer.settings import Refusal, RefusedError, Settings, read_settings
from studies.output.season_scale import page_scale
from studies.quantities import EXCESS_TIME

_PLACE = (LATITUDE, DAY)
_ALTITUDE, _FLOOR = ALTITUDE.removeprefix(MISSION_PREFIX), "climb.minimum_altitude_m"

# Excess times are then within 0.05 h in 99 of 100 cells: see docs/explorer.md.
COARSE_STEP_H = 0.25
# Evenly spaced: the page interpolates. A coarse map has every second row and column.
LATITUDES_DEG, DAYS = np.linspace(-90.0, 90.0, 73), np.arange(1, 366, 4)
COARSE_LATITUDES_DEG, COARSE_DAYS = LATITUDES_DEG[::2], DAYS[::2]
_DAYS_ON_PATH = DAYS[::4]
# Keys of the mission that light knows of; the rest of it changes the load alone. Wind turns the
# modules of an aircraft that follows a path.
_KEYS_OF_LIGHT = ("altitude_m", "climb", "air", "clear_sky", "clearness", "uncertainty_margins")
_KEYS_OF_PATH = ("wind_m_per_s", "wind_statistics", "wind_from_deg", "flight_path")
_KEPT = 6  # lights, of 16 MB at most each
# Of filling a slow map, before others have their turn: while a slider moves, and when it rests.
_SHORT_TURN_S, _TURN_S = 0.02, 0.12


@dataclass
class _Light:
    """Light of the rows of a map that are known, in their order; ``None`` before the first."""

    rows: list[int]
    day: SolarDay | None = None

    def add(self, row: int, day: SolarDay) -> None:
        """Take another row."""
        self.rows.append(row)
        self.day = day if self.day is None else SolarDay.joined([self.day, day])


class Session:
    """An aircraft on a mission, and every change that the page can make to them.

    ``case``: aircraft and mission as their files have them, and the model at the start.
    ``command``: how the command line names both, for the command that the page shows.
    """

    def __init__(self, case: Case, *, command: Sequence[str] = ()) -> None:
        self.case, self.aircraft, self.mission = case, case.aircraft, case.mission
        self.command = list(command)
        self._light = lru_cache(_KEPT)(lambda *settings: _Light([]))
        self._last_day: tuple[Settings, dict[str, Any], Design] | None = None
        # The scenario that is hardest to fly is where the page begins.
        start = analyse(**case.arguments, replay=False)
        scenarios = start.performance.day.scenarios
        self.scenarios = [scenarios.label(i) for i in range(len(scenarios))]
        at = (float(scenarios.latitude_deg[start.worst]), int(scenarios.day_of_year[start.worst]))
        self.fields: dict[str, Field | Choice] = fields_of(
            self.aircraft, self.mission, case.solar, at
        )

    @property
    def measured(self) -> bool:
        """Whether the airframe is measured, so that it cannot be sized."""
        return isinstance(self.aircraft.airframe, MeasuredAirframe)

    def describe(self) -> dict[str, Any]:
        """Return names, fields, choices and objectives of the page, JSON-ready."""
        objectives = [
            {
                "name": entry.value,
                "label": f"{'largest' if entry.maximised else 'least'} {entry.label}",
                "unit": "" if entry.unit == "1" else entry.unit,
            }
            for entry in SINGLE_OBJECTIVES
        ]
        return {
            "version": __version__,
            "command": self.command,
            "aircraft": {
                "name": self.aircraft.name,
                "description": self.aircraft.description,
                "measured": self.measured,
            },
            "mission": {
                "name": self.mission.name,
                "description": self.mission.description,
                "scenarios": self.scenarios,
                "climbs": self.mission.climb is not None,
                "wind": self.mission.wind_statistics is not None,
            },
            "fields": [
                entry.to_dict() for entry in self.fields.values() if isinstance(entry, Field)
            ],
            "choices": [
                asdict(choice) for choice in self.fields.values() if isinstance(choice, Choice)
            ],
            "objectives": objectives,
            "season_scale": page_scale(),
            "cannot_size": (
                "a measured airframe cannot be sized: its mass does not follow from its geometry"
                if self.measured
                else ""
            ),
        }

    def settings(self, data: object = None) -> Settings:
        """Check what a page sent: see :func:`studies.explorer.settings.read_settings`."""
        return read_settings({} if data is None else data, self.fields)

    def inputs(self, settings: Settings, *, every_scenario: bool = False) -> Case:
        """Return aircraft and mission of settings, as their files would be.

        ``every_scenario``: keep latitudes and dates of the mission's file instead of the single
        point.
        """
        changed = {
            key: value
            for key, value in settings.values.items()
            if value != self.fields[key].value and key not in _PLACE
        }
        of_mission: dict[str, Any] = {
            key.removeprefix(MISSION_PREFIX): value
            for key, value in changed.items()
            if key.startswith(MISSION_PREFIX)
        }
        unmoved = all(settings.values[key] == self.fields[key].value for key in _PLACE)
        if not every_scenario and not (unmoved and len(self.scenarios) == 1):
            date = {"on": date_code(int(settings.values[DAY]))}
            of_mission |= {"latitude_deg": settings.values[LATITUDE], "dates": date}
            if self.mission.launch is not None:  # one at its own place and day
                of_mission["launch"] = None
        climb = self.mission.climb  # whose floor may stand in place of the altitude
        if _ALTITUDE in of_mission and climb is not None and climb.minimum_altitude_m is not None:
            of_mission[_FLOOR] = of_mission.pop(_ALTITUDE)
        of_aircraft = {k: v for k, v in changed.items() if not k.startswith(MISSION_PREFIX)}
        try:
            return Case(
                self.case.aircraft_file.changed(of_aircraft),
                self.case.mission_file.changed(of_mission),
                solar=settings.solar,
            )
        except InputError as error:
            refusals = []
            for problem in error.problems:
                at = _ALTITUDE if problem.key == _FLOOR else problem.key
                named = (k for k in settings.values if k.removeprefix(MISSION_PREFIX) == at)
                key = next(named, problem.key)
                refusals.append(Refusal(key, settings.values.get(key), problem.message))
            raise RefusedError(refusals, "contradiction") from None

    def analysis(self, settings: Settings) -> Analysis:
        """Analyse the point, as ``solar-uav analyse`` does."""
        made = self.inputs(settings)
        with _told_to_the_page(made.solar):
            return analyse(**made.arguments, replay=False)

    def day(self, settings: Settings) -> dict[str, Any]:
        """Return day curve and numbers of the point, JSON-ready.

        Returns ``curve``: ``time_h``, ``solar_power_w``, ``load_w``, ``state_of_charge`` over solar
        time, to five digits, and ``flight_charge``, that of a limited flight in the first day after
        its launch with a full battery, null where it does not fly; with climbs ``altitude_m`` as
        well, and ``flight_charge`` is that in level flight; ``numbers``: what ``solar-uav
        analyse --json`` prints; ``masses_kg``: mass budget; ``headline`` and ``notes`` in words.
        """
        known = self._last_day
        if known is not None and known[0] == settings:
            return known[1].copy()  # the page asks again for the exact map
        analysis = self.analysis(settings)
        perf, record = analysis.performance, analysis.to_dict()
        del record["scenarios"]
        notes = [extrapolation.text for extrapolation in analysis.extrapolations]
        if record["airspeed_above_wind"] is False:
            airspeed, wind = record["airspeed_m_per_s"], analysis.mission.strongest_wind_m_per_s
            held = "is raised to" if analysis.mission.holds_station else "is below"
            notes.insert(0, f"airspeed {airspeed:.1f} m/s {held} the wind of {spell(wind)} m/s")
        time_h, flight = perf.day.time_h, analysis.limited_flight
        flight_charge: list[float | None] = [None] * len(time_h)
        if flight is not None:
            course = perf.course(0, flight.launch_h, flight.endurance_h)
            at_h = np.where(time_h < flight.launch_h, time_h + 24.0, time_h)
            # What remains of the second day ends a node before the launch, where the battery was
            # full.
            at_h[max(int(np.searchsorted(time_h, flight.launch_h)) - 1, 0)] = np.inf
            charge = np.interp(at_h, course.clock_h, course.state_of_charge, right=np.nan)
            flight_charge = [finite(value) for value in charge.round(5).tolist()]
        curves = {name: _digits(each[0]) for name, each in analysis.curves.items()}
        del curves["energy_wh"]
        view: dict[str, Any] = {
            "curve": {
                "time_h": _digits(time_h),
                **curves,
                "flight_charge": flight_charge,
            },
            "numbers": record,
            "masses_kg": {name: float(mass) for name, mass in perf.design.masses._asdict().items()},
            "headline": analysis.headline(),
            "notes": notes,
        }
        self._last_day = settings, view, perf.design
        return view.copy()

    def season(self, settings: Settings, *, coarse: bool = False) -> dict[str, Any]:
        """Return the map of excess time over latitude and day of year.

        ``coarse``: every second row and column, in steps of a quarter of an hour; slow models
        always have these, and flights with climbs these rows and columns. Returns
        ``latitudes_deg``, ``days``, ``step_h`` and ``excess_time_h``: rows of hours to three
        decimals, null where it is unlimited; a row that is not yet known is null, and so is one
        whose wind nobody knows. ``complete`` says whether there is none of the former.
        """
        made, last = self.inputs(settings), self._last_day
        design = last[2] if last is not None and last[0] == settings else None
        with _told_to_the_page(made.solar):
            return self._excess_times(made, design, coarse=coarse)

    def _excess_times(self, made: Case, design: Design | None, *, coarse: bool) -> dict[str, Any]:
        aircraft, mission, solar = made.aircraft, made.mission, made.solar
        on_path = solar.needs_path
        few = coarse or mission.climb is not None  # whose march takes as long as four others
        step_h = COARSE_STEP_H if coarse or on_path else DEFAULT_STEP_H
        latitudes = COARSE_LATITUDES_DEG if few or on_path else LATITUDES_DEG
        days = _DAYS_ON_PATH if on_path else COARSE_DAYS if few else DAYS
        # Of an area of modules, filled once for each of its settings.
        modules = aircraft.modules.model_copy(update={"area_m2": 1.0})
        names = _KEYS_OF_LIGHT + (_KEYS_OF_PATH if on_path else ())
        light = self._light(modules, *(getattr(mission, name) for name in names), solar, step_h)
        south, north = solar.latitudes_with_wind_deg(mission)
        known = np.flatnonzero((latitudes >= south) & (latitudes <= north))

        def sunlight_at(latitudes_deg: FloatArray) -> SolarDay:
            latitude, day = np.meshgrid(latitudes_deg, days, indexing="ij")
            cells = Scenarios(latitude.ravel(), day.ravel())
            return solar_day(aircraft, mission, solar, scenarios=cells, step_h=step_h)

        if on_path:
            _fill(light, sunlight_at, known.tolist(), _SHORT_TURN_S if coarse else _TURN_S)
        elif light.day is None:
            light.rows, light.day = known.tolist(), sunlight_at(latitudes[known])
        rows: list[list[float | None] | None] = [None] * len(latitudes)
        flight = performance(
            aircraft, mission, solar, day=light.day, keep_trajectory=False, design=design
        )
        hours = flight.cycle.excess_time_h.reshape(len(light.rows), len(days))
        for row, values in zip(light.rows, hours, strict=True):
            rows[row] = [round(v, 3) if isfinite(v) else None for v in values.tolist()]
        return {
            "latitudes_deg": latitudes.tolist(),
            "days": days.tolist(),
            "step_h": step_h,
            EXCESS_TIME.name: rows,
            "complete": len(light.rows) == len(known),
        }

    def file_names(self) -> dict[str, str]:
        """Return names for what is saved: ``aircraft``, ``mission`` and ``report``."""
        name = re.sub(r"[^A-Za-z0-9_.-]+", "-", self.aircraft.name).strip("-.")[:60] or "aircraft"
        if names_a_device(name):
            name = f"aircraft-{name}"
        stem = f"{name}-explored"
        return {
            "aircraft": f"{stem}.yaml",
            "mission": f"{stem}-mission.yaml",
            "report": f"{stem}.html",
        }

    def saved(self, settings: Settings) -> dict[str, Any]:
        """Return the files, names for them, and the command that analyses them."""
        names, solar = self.file_names(), settings.solar
        words = ["solar-uav", "analyse", names["aircraft"], "--mission", names["mission"]]
        words += ["--model", solar.model, "--correction", solar.correction]
        texts = self.files(settings)
        return {
            "command": shlex.join(words),
            "files": [{"name": names[kind], "text": text} for kind, text in texts.items()],
        }

    def files(self, settings: Settings) -> dict[str, str]:
        """Return the texts of the two files by ``aircraft`` and ``mission``."""
        made, head = self.inputs(settings), f"Written by solar-uav {__version__} explore from"
        documents = {
            "aircraft": made.aircraft_file.document,
            "mission": made.mission_file.document,
        }
        return {
            kind: file_text(f"{head} {document.source}", document.data)
            for kind, document in documents.items()
        }


@contextmanager
def _told_to_the_page(solar: SolarModel) -> Iterator[None]:
    """Refuse a point that cannot be computed."""
    try:
        yield
    except ImpossibleDesignError as error:
        raise RefusedError([Refusal("design", None, str(error))], "impossible") from None
    except ValueError as error:  # a path that the wind does not let be flown
        raise RefusedError([Refusal("model", solar.model, str(error))]) from None


def _digits(values: Any) -> list[float]:
    """Return numbers with five digits: more than a screen has pixels."""
    return [significant(value, 5) for value in np.asarray(values).tolist()]


def _fill(
    light: _Light, sunlight_at: Callable[[FloatArray], SolarDay], known: list[int], turn_s: float
) -> None:
    """Add rows that are missing, as many as a turn allows and at least one."""
    end = time.monotonic() + turn_s
    # Every eighth row first: a part of them covers the whole evenly.
    count = len(COARSE_LATITUDES_DEG)
    for row in dict.fromkeys(n for stride in (8, 4, 2, 1) for n in range(0, count, stride)):
        if row in light.rows or row not in known:
            continue
        light.add(row, sunlight_at(COARSE_LATITUDES_DEG[row : row + 1]))
        if time.monotonic() > end:
            return
