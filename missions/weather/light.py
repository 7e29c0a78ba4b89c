"""Light at flight altitude over time, from the interval means of a weather record; its days.

Within an interval the light follows the clear sky's course, scaled to the record's mean of direct
and of diffuse light, which is kept exactly. The same shares of clear light hold at flight altitude:
clouds and haze of the record are taken to be above the aircraft, and thinner air adds as much as
under a clear sky.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missions.weather.record import SECONDS_PER_HOUR, Site, Weather, day_of_year, sun_over
from solar.clearsky import Irradiance, clear_sky, extraterrestrial_irradiance
from solar.schema import Allowed
from solar.sun import HOURS_PER_DAY, SECONDS_PER_DAY
from solar.types import FloatArray, IntArray

NODE_STEP_S = 300.0
# Clear-sky means below this are too small to be divided by [W/m2].
_LEAST_MEAN = 1.0


@dataclass(frozen=True)
class RecordedLight:
    """Light, sun and air at even nodes along a record.

    ``site``: place of measurement. ``time_s``: universal time of the nodes, the middles of equal
    steps [s since 1970-01-01]. ``step_h``: length of the steps [h]. ``day_of_year``,
    ``time_solar_h``: fractional day of year (UTC) and local solar time, 0 to 24 [h].
    ``cos_zenith``: cosine of the sun's zenith angle [-]. ``recorded``, ``clear``: light of the
    record and of a clear sky [W/m2], ``temperature_c``: air temperature [C], ``wind_m_per_s``:
    wind [m/s], all at flight altitude.
    """

    site: Site
    time_s: FloatArray
    step_h: float
    day_of_year: FloatArray
    time_solar_h: FloatArray
    cos_zenith: FloatArray
    recorded: Irradiance
    clear: Irradiance
    temperature_c: FloatArray | None
    wind_m_per_s: FloatArray | None


def light_at_altitude(
    weather: Weather, altitude_m: float, *, step_s: float = NODE_STEP_S
) -> RecordedLight:
    """Return the light of a weather record at flight altitude, at a whole number of nodes a day.

    ``step_s``: largest distance of the nodes [s]; shorter intervals of a record are averaged over
    whole numbers of them.
    """
    Allowed(1.0, 3.0 * SECONDS_PER_HOUR).check("step_s", step_s)
    many = int(step_s / weather.interval_s + 1e-9)
    if many > 1:  # means over whole numbers of its intervals, up to the step
        rows = len(weather) // many * many
        means: dict[str, Any] = {
            name: values[:rows].reshape(-1, many).mean(axis=1)
            for name, values in vars(weather).items()
            if isinstance(values, np.ndarray)
        }
        means["start_s"] = weather.start_s[:rows:many]
        weather = replace(weather, interval_s=weather.interval_s * many, **means)
    parts = max(1, int(np.ceil(weather.interval_s / step_s - 1e-9)))
    while (SECONDS_PER_DAY * parts / weather.interval_s) % 1.0 > 1e-9:
        parts += 1
    step = weather.interval_s / parts
    time_s = (weather.start_s[:, np.newaxis] + step * (np.arange(parts) + 0.5)).reshape(-1)
    site = weather.site
    day, solar_h, cosine = sun_over(site, time_s)
    low = clear_sky(day, site.latitude_deg, cosine, site.altitude_m)
    high = clear_sky(day, site.latitude_deg, cosine, altitude_m)
    shape = (len(weather), parts)
    direct = _distribute(weather.dni, low.dni.reshape(shape), cosine.reshape(shape)).reshape(-1)
    diffuse = _distribute(weather.dhi, low.dhi.reshape(shape), cosine.reshape(shape)).reshape(-1)
    most = extraterrestrial_irradiance(day)
    recorded = Irradiance(
        np.minimum(direct * _gain(high.dni, low.dni), most), diffuse * _gain(high.dhi, low.dhi)
    )
    temperature, wind = weather.temperature_c, weather.wind_m_per_s
    measured_m, ratio = weather.air_altitude_m, 1.0
    if measured_m is None:
        measured_m, ratio = site.altitude_m, wind_ratio(altitude_m - site.altitude_m)
    return RecordedLight(
        site=site,
        time_s=time_s,
        step_h=step / SECONDS_PER_HOUR,
        day_of_year=day,
        time_solar_h=solar_h,
        cos_zenith=cosine,
        recorded=recorded,
        clear=high,
        temperature_c=None
        if temperature is None
        else _interpolate_to_nodes(temperature, parts) - LAPSE_K_PER_M * (altitude_m - measured_m),
        wind_m_per_s=None if wind is None else _interpolate_to_nodes(wind, parts) * ratio,
    )


# Temperature falls with height as in the standard atmosphere (ISO 2533:1975).
LAPSE_K_PER_M = 0.0065
# Power law of the wind over open ground, exponent 1/7: Peterson, E. W. and Hennessey, J. P. (1978),
# On the use of power laws for estimates of wind power potential, J. Appl. Meteorol. 17, 390-394.
WIND_EXPONENT = 1.0 / 7.0
WIND_MEASURED_AT_M = 10.0
# Above the surface layer and the boundary layer's lower part the law says nothing.
WIND_LAW_UP_TO_M = 300.0


def wind_ratio(above_ground_m: float) -> float:
    """Return the wind at a height over the wind at 10 m, by the power law up to 300 m [-]."""
    height = min(max(above_ground_m, WIND_MEASURED_AT_M), WIND_LAW_UP_TO_M)
    return float((height / WIND_MEASURED_AT_M) ** WIND_EXPONENT)


def _distribute(mean: FloatArray, clear: FloatArray, cosine: FloatArray) -> FloatArray:
    """Distribute interval means over their steps along the clear sky's course.

    With next to no clear light, spread evenly over steps with the sun above the horizon; without
    such steps dropped, for no level surface sees it.
    """
    clear_mean = clear.mean(axis=1)
    daylight = cosine > 0.0
    count = daylight.sum(axis=1)
    even = np.where(daylight, (daylight.shape[1] / np.maximum(count, 1))[:, np.newaxis], 0.0)
    usable = clear_mean > _LEAST_MEAN
    shape = np.where(
        usable[:, np.newaxis], clear / np.where(usable, clear_mean, 1.0)[:, np.newaxis], even
    )
    return mean[:, np.newaxis] * shape


def _gain(high: FloatArray, low: FloatArray) -> FloatArray:
    """Return clear light at flight altitude over clear light at the ground, 1 in the dark."""
    return np.divide(high, low, out=np.ones_like(low), where=low > _LEAST_MEAN)


def _interpolate_to_nodes(values: FloatArray, parts: int) -> FloatArray:
    """Interpolate interval means at the middles of their steps."""
    places = (np.arange(len(values) * parts) + 0.5) / parts - 0.5
    return np.interp(places, np.arange(len(values)), values)


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
