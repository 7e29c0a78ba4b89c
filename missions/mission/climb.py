"""Flight at more than one height: surplus power stored as height by day."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M
from missions.mission.scenarios import OTHER_NAME, Altitude
from solar.schema import Record, spell, wrong_value

# Of a flight with climbs: between levels everything is linear.
LEVEL_SPACING_M = 500.0
MAXIMUM_LEVELS = 21


class Climb(Record):
    """Surplus power stored as height by day, to sink to the mission's altitude in the evening.

    The height profile is the best there is: ``strategy``, when to climb, is read and ignored.
    ``minimum_altitude_m``: the night's floor, which the aircraft does not sink below; another name
    for the mission's altitude, which need not be given beside it.
    """

    explained_keys: ClassVar[Mapping[str, str]] = {
        "maximum_altitude_m": "the highest altitude is climb.ceiling_m",
        "design_space": "altitudes are not chosen by size: give climb.ceiling_m, and vary it with "
        "sweep --resize --vary mission.climb.ceiling_m=...",
    }

    ceiling_m: Altitude
    minimum_altitude_m: Altitude | None = None
    strategy: Literal["battery_full", "surplus"] | None = None

    def check(self, altitude_m: float) -> None:
        """Refuse a floor or a ceiling that contradicts the mission's altitude."""
        floor_m, key = self.minimum_altitude_m, "climb.minimum_altitude_m"
        if floor_m is not None and floor_m > self.ceiling_m:
            text = f"must be at most climb.ceiling_m of {spell(self.ceiling_m)}"
            raise wrong_value(key, text, got=floor_m)
        if floor_m is not None and floor_m != altitude_m:
            raise wrong_value(key, OTHER_NAME.format("altitude_m", spell(altitude_m)), got=floor_m)
        if self.ceiling_m < altitude_m:
            text = f"must be at least the mission's altitude_m of {spell(altitude_m)}"
            raise wrong_value("climb.ceiling_m", text, got=self.ceiling_m)

    @property
    def record(self) -> dict[str, Any]:
        """Return the ceiling, JSON-ready; the floor is the mission's altitude."""
        return {"ceiling_m": self.ceiling_m}

    def levels_m(self, floor_m: float) -> list[float]:
        """Return altitudes between which a flight is linear, from its floor to its ceiling.

        At most 500 m apart, where the curvature of the pressure is 0.05 %; of more than 10 km of
        climb there are 21.
        """
        count = int(np.ceil((self.ceiling_m - floor_m) / LEVEL_SPACING_M - 1e-9)) + 1
        levels = np.linspace(floor_m, self.ceiling_m, min(max(count, 2), MAXIMUM_LEVELS))
        return [float(level) for level in levels]


def altitude_of_floor(data: Mapping[str, Any], climb: Any) -> Mapping[str, Any]:
    """Return the data of a mission with the night's floor as its altitude, where a file has that.

    An altitude of null leaves that of a file to the floor.
    """
    keys = vars(climb) if isinstance(climb, Climb) else climb
    if data.get("altitude_m") is not None or not isinstance(keys, Mapping):
        return data
    floor_m = keys.get("minimum_altitude_m")
    # What is no altitude is refused once, at its key.
    if not isinstance(floor_m, int | float) or isinstance(floor_m, bool):
        return data
    allowed = MINIMUM_ALTITUDE_M <= floor_m <= MAXIMUM_ALTITUDE_M
    return {**data, "altitude_m": floor_m} if allowed else data
