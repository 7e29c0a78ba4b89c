"""What a mission with climbs asks of an aircraft and of a command, told in terms of the files."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from studies.cli.files import LoadedAircraft, LoadedMission


def refuse_climb(where: LoadedMission, command: str) -> None:
    """Refuse a mission with climbs where flight at constant altitude is meant.

    Raises
    ------
    InputError
        If the mission has ``climb``.
    """
    if where.mission.climb is None:
        return
    from missions.files.validation import located_error

    raise located_error(
        where.document,
        ("climb",),
        f"{command} flies at constant altitude; remove climb (solar-uav analyse uses it)",
    )


def require_climber(craft: LoadedAircraft, where: LoadedMission) -> None:
    """Refuse an aircraft that cannot climb on a mission that has climbs.

    Raises
    ------
    InputError
        If a key of the aircraft is missing, or leaves no power to climb with.
    """
    if where.mission.climb is None:
        return
    from missions.files.validation import located_error
    from sizing.altitude.climb_levels import ClimbLimitError, climb_limits
    from sizing.design import design_of

    try:
        climb_limits(craft.aircraft, design_of(craft.aircraft, where.mission))
    except ClimbLimitError as error:
        raise located_error(craft.document, error.key, error.message) from None
