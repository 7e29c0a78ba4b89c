"""Days of a weather record: their nodes and dates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missions.weather.light import RecordedLight
from missions.weather.record import SECONDS_PER_HOUR, day_of_year
from solar.sun import HOURS_PER_DAY
from solar.types import FloatArray, IntArray

# A record that begins this near to midnight begins a day.
_NEAR_MIDNIGHT_H = 3.0


@dataclass(frozen=True)
class DayAxis:
    """Days of a record, from one local solar midnight to the next, and their nodes.

    ``nodes``: indices in the record, shape ``(day, node)``; a day's last node is the next day's
    first. ``time_h``: hours since the day's first node [h]. ``midnight_h``: solar time of each
    day's first node, about 0 [h]. ``date``: date of each day in the site's calendar.
    ``day_of_year``: 1 to 365; 29 February counts as 28 February. ``time_s``: universal time of each
    day's first node [s since 1970-01-01].
    """

    nodes: IntArray
    time_h: FloatArray
    midnight_h: FloatArray
    date: NDArray[np.datetime64]
    day_of_year: IntArray
    time_s: FloatArray

    def __len__(self) -> int:
        return len(self.nodes)

    @property
    def year(self) -> IntArray:
        """Calendar year of each day."""
        return self.date.astype("datetime64[Y]").astype(int) + 1970

    @property
    def month(self) -> IntArray:
        """Month of each day, 1 to 12."""
        return self.date.astype("datetime64[M]").astype(int) % 12 + 1

    @classmethod
    def of(cls, light: RecordedLight) -> DayAxis:
        """Cut a record into days; hours before the first and after the last are left out."""
        per_day = round(HOURS_PER_DAY / light.step_h)
        begin_h = float(light.time_solar_h[0])
        to_midnight_h = (HOURS_PER_DAY - begin_h) % HOURS_PER_DAY
        near = min(begin_h, to_midnight_h) <= _NEAR_MIDNIGHT_H
        skip = 0 if near else round(to_midnight_h / light.step_h)
        count = (len(light.time_s) - skip) // per_day
        if count < 1:
            raise ValueError("is shorter than a day from one solar midnight to the next")
        first = skip + per_day * np.arange(count)
        nodes = np.minimum(first[:, np.newaxis] + np.arange(per_day + 1), len(light.time_s) - 1)
        clock_h = light.time_solar_h[first]
        midnight_h = np.where(clock_h > 12.0, clock_h - HOURS_PER_DAY, clock_h)
        # Dates at the site's noon, not Greenwich's, on its zone's side of the date line. A file
        # without a time zone has an offset of zero; the longitude alone sets its calendar.
        solar_h = light.site.longitude_deg / 15.0
        zone_h = solar_h + 24.0 * float(np.rint((light.site.utc_offset_h - solar_h) / 24.0))
        noon_h = HOURS_PER_DAY / 2.0 - midnight_h + zone_h
        date = (light.time_s[first] + SECONDS_PER_HOUR * noon_h).astype("datetime64[s]")
        date = date.astype("datetime64[D]")
        return cls(
            nodes=nodes,
            time_h=np.asarray(np.arange(per_day + 1) * light.step_h, float),
            midnight_h=midnight_h,
            date=date,
            day_of_year=day_of_year(date.astype("datetime64[s]").astype(float)).astype(int),
            time_s=light.time_s[first],
        )
