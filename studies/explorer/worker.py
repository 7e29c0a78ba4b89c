"""Sizings and reports in a process of their own: one at a time, ended when nobody waits any more.

CasADi's solver is not safe in two threads of a process and cannot be interrupted in one; a report
draws for seconds.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from missions.files.errors import InputError
from sizing.design import variable_keys
from sizing.mass_budget import ImpossibleDesignError
from sizing.parameters import MISSION_PREFIX, with_parameter
from sizing.performance import performance
from sizing.program.objectives import Objective
from solar.schema import significant, spell
from studies.case import Case
from studies.engine.workers import Pool
from studies.explorer.settings import AnsweredError
from studies.output.figures.options import ignore_settings_of_folder
from studies.output.run_folder import InputFile
from studies.render.words import constraint_words, parameter_words, percent

if TYPE_CHECKING:
    from sizing.results.sizing_study import SizingStudy

LONGEST_S = 180.0
_PAYLOAD_KEYS = ("mass_kg", "power_w")


class Worker:
    """The process, started with the first task and kept for the next."""

    def __init__(self, longest_s: float = LONGEST_S) -> None:
        self._longest_s, self._busy = longest_s, threading.Lock()
        self._pool: Pool | None = None

    def run(self, work: Callable[..., dict[str, Any]], *task: Any) -> dict[str, Any]:
        """Give the process a task, and wait for it.

        Returns what it returns, or ``error``: why it cannot.
        """
        if not self._busy.acquire(blocking=False):
            words = "another sizing or report is being made; wait, or cancel it"
            raise AnsweredError(words, 409, "busy")
        try:
            self._pool = self._pool or Pool(1, in_process=False)
            return self._pool.submit(_answer, work, *task).result(self._longest_s)
        except TimeoutError:
            self.end()
            words = f"no answer within {spell(self._longest_s)} s"
            raise AnsweredError(words, 503, "ended") from None
        except (BrokenExecutor, CancelledError) as error:
            raise AnsweredError("cancelled, or the process ended", 503, "ended") from error
        finally:
            self._busy.release()

    def end(self) -> None:
        """End the process, in the middle of a task if need be; the next starts another one."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.close(at_once=True)


def _answer(work: Callable[..., dict[str, Any]], *task: Any) -> dict[str, Any]:
    ignore_settings_of_folder()
    try:
        return work(*task)
    except (InputError, ImpossibleDesignError, ValueError) as error:
        return {"error": str(error)}


def report_page(case: Case) -> dict[str, Any]:
    """Report in this process: ``text`` is the page, HTML that needs no other file."""
    from studies.report import document, subject

    inputs = case.inputs()
    files = {k: InputFile(f"{file.source}, as explored", None) for k, file in inputs.files.items()}
    inputs = replace(inputs, files=files)
    shown = subject.Subject(case.aircraft, case.mission, case.solar, inputs)
    return {"text": document.render(shown)}


def sizing_record(case: Case, objective: Objective) -> dict[str, Any]:
    """Size in this process.

    Returns ``feasible``, ``status``, ``headline`` and ``text`` (what the command line prints);
    ``record``, what ``solar-uav size --json`` prints; ``limits``, ``missed`` and ``relaxations`` in
    words, each with its ``label``; ``values``, the optimum by the keys of the page, and its
    ``worst_scenario``; both null without an optimum. ``with_margin``: such ``values`` of the
    optimum that keeps the requirement with one RMS error less solar power, with its ``headline``,
    ``worst_scenario`` and the ``error`` in words; null where there is none.
    """
    from sizing.results.sizing import size

    scenarios = case.mission.scenarios()
    dark = scenarios.in_polar_night()
    if dark.any():
        where = scenarios.label(int(dark.argmax()))
        raise ValueError(f"polar night: the sun never rises at {where}, so that no design flies")
    study = size(**case.arguments, objective=objective, with_margin=True)
    record, guarded = study.to_dict(), study.with_margin
    error = f"one RMS error of {study.solar.model} ({percent(study.solar.rms_relative, '.0f')})"
    return {
        "feasible": study.feasible,
        "status": study.status.label,
        "text": str(study),
        "record": record,
        "limits": [
            constraint_words(name, study.aircraft).without_key
            for name in study.result.active_constraints
        ],
        "missed": [entry.text for entry in study.result.violations],
        "relaxations": [
            entry | {"label": parameter_words(entry["parameter"])}
            for entry in record.get("relaxations", [])
        ],
        **_optimum(study),
        "with_margin": None if guarded is None else _optimum(guarded) | {"error": error},
    }


def _optimum(study: SizingStudy) -> dict[str, Any]:
    """Return an optimum in words, by the keys of the page, and where it is hardest.

    Its values have six digits where those meet the requirement.
    """
    known = {"headline": study.headline(), "worst_scenario": study.to_dict()["worst_scenario"]}
    if study.design is None:
        return known | {"values": None}
    chosen, payload = study.design.variables, study.sized_mission().payload
    values = {key: getattr(chosen, name) for key, name in variable_keys().items()}
    values |= {f"{MISSION_PREFIX}payload.{key}": getattr(payload, key) for key in _PAYLOAD_KEYS}
    exact = {key: float(value) for key, value in values.items() if value is not None}
    short = {key: significant(value) for key, value in exact.items()}
    aircraft, mission = study.sized_aircraft(), study.sized_mission()
    for key, value in short.items():
        aircraft, mission = with_parameter(aircraft, mission, key, value)
    perf = performance(aircraft, mission, study.solar, keep_trajectory=False)
    enough = float(perf.cycle.excess_time_h.min()) >= study.result.required_excess_time_h
    fits = perf.design.variables.module_area_m2 <= perf.design.wing_area_m2
    return known | {"values": short if enough and fits else exact}
