"""What a command needs of aircraft and mission, told in terms of their files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import click

from missions.files.errors import InputError, Problem
from missions.files.validation import located_error
from missions.flight_path import path_trouble
from sizing.aircraft import MeasuredAirframe
from sizing.altitude.climb_levels import ClimbLimitError, checked_climb_limits
from sizing.design import design_of
from solar.names import ATTITUDE_MODELS
from studies.cli.files import Case

# Why a study cannot fly climbs.
IN_WEATHER = "a weather record does not tell how high its clouds are"
IN_WINDS = "the percentiles of the winds at several heights have none in common"
OFFLINE = "its page has the light of one altitude"


def refuse_climb(case: Case, command: str, why: str) -> None:
    """Refuse a mission with climbs where flight at constant altitude is meant."""
    if case.mission.climb is not None:
        message = f"{command} flies at constant altitude, as {why}; remove climb"
        raise located_error(case.where.document, ("climb",), message)


def refuse_held_station(case: Case, command: str) -> None:
    """Refuse a mission that holds its place where one power is flown in all scenarios."""
    if case.mission.holds_station:
        message = f"{command} has one power of level flight for all places and days; leave it out"
        raise located_error(case.where.document, ("wind", "hold_station"), message)


def require_climber(case: Case) -> None:
    """Refuse an aircraft that cannot climb on a mission that has climbs."""
    if case.mission.climb is None:
        return
    try:
        checked_climb_limits(case.aircraft, design_of(case.aircraft, case.mission))
    except ClimbLimitError as error:
        raise located_error(case.craft.document, error.key, error.message) from None


def require_climb_power(case: Case) -> None:
    """Refuse a parametric aircraft that is sized for climbs without any power for them."""
    propulsion = getattr(case.aircraft.airframe, "propulsion", None)
    ratio = getattr(propulsion, "climb_power_ratio", None)
    if case.mission.climb is not None and ratio is not None and ratio <= 1.0:
        message = (
            f"a mission with climb needs more power than level flight takes; allowed: above 1 "
            f"(got {ratio:g}), or climb_rate_m_per_s"
        )
        key = ("airframe", "propulsion", "climb_power_ratio")
        raise located_error(case.craft.document, key, message)


def require_path(case: Case, option: str | None = None) -> None:
    """Refuse an aircraft without module surfaces and a mission without a path it can fly.

    ``option``: what needs both, for the message; if left out, VM, FM and the loiter correction do.
    """
    solar = case.solar
    if option is None:
        if not solar.needs_path:
            return
        attitude = solar.model in ATTITUDE_MODELS
        option = f"--model {solar.model}" if attitude else "--correction loiter"
    if case.aircraft.modules.geometry is None:
        message = f"{option} needs the module surfaces: add geometry with its surfaces"
        raise located_error(case.craft.document, ("modules",), message)
    if case.mission.flight_path is None:
        message = f"{option} needs a flight path: add flight_path with kind, radius_m, ..."
        raise located_error(case.where.document, ("name",), message)
    trouble = path_trouble(case.mission.flight_path, case.mission.wind)
    if trouble is not None:
        raise located_error(case.where.document, ("flight_path",), trouble)


def refuse_polar_night(case: Case) -> None:
    """Refuse scenarios in which the sun never rises: no design could fly through them."""
    scenarios = case.mission.scenarios()
    dark = scenarios.in_polar_night()
    if dark.any():
        label = scenarios.label(int(dark.argmax()))
        message = (
            f"polar night: the sun never rises at {label}; allowed: latitudes and dates with sun"
        )
        raise located_error(case.where.document, ("latitude_deg",), message)


def require_parametric(case: Case, message: str) -> None:
    """Refuse a measured aircraft where masses and power must follow from the design."""
    if isinstance(case.aircraft.airframe, MeasuredAirframe):
        raise located_error(case.craft.document, ("airframe", "kind"), message)


def require_whole_cells(case: Case) -> None:
    """Refuse an aircraft whose file lays no solar cells or has no whole cells in its battery."""
    for section, key, given in (
        ("modules", "layout", case.aircraft.modules.layout),
        ("battery", "pack", case.aircraft.battery.pack),
    ):
        if given is None:
            message = "required key is missing: --whole-cells needs it"
            raise located_error(case.craft.document, (section, key), message)


@contextmanager
def uncertain_inputs_of(case: Case) -> Iterator[None]:
    """Tell what is wrong with uncertain inputs by the lines of the files."""
    try:
        yield
    except InputError as error:
        raise _placed(case, error) from error
    except ValueError as error:
        raise click.UsageError(str(error)) from error


def _placed(case: Case, error: InputError) -> InputError:
    """Error with the lines of the files that its keys stand on."""
    placed = []
    for problem in error.problems:
        first, _, rest = problem.key.partition(".")
        second, _, key = rest.partition(".")
        found = problem
        for owner, document in (
            (case.aircraft.name, case.craft.document),
            (case.mission.name, case.where.document),
        ):
            if owner != problem.source:
                continue
            path = (first, second, key) if key else (first, second)
            mark = document.key_marks.get(path)
            line, column = mark or (None, None)
            found = Problem(document.source, line, column, problem.key, problem.message)
            break
        placed.append(found)
    return InputError(placed)
