"""Synthetic flights on random clear days: false alarms, and errors of the log that are put in.

``python -m benchmarks.log_offsets --days 200`` prints what ``docs/verify.md`` says of them.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from missions.files.overrides import with_values
from missions.library import load_mission
from missions.logs.table import EulerAngles, FlightLog
from missions.mission import Mission
from sizing.library import load_aircraft
from studies.flight_logs.alignment.offsets import align
from studies.flight_logs.synthetic import START_UTC_S, Settings, synthetic_log
from studies.flight_logs.verification import verify

CLOCKS_S = (7200.0, -19800.0, 3600.0, 36000.0, 1200.0, -900.0)
HEADINGS_DEG = (90.0, -90.0, 180.0, 30.0, -20.0)


def random_days(count: int) -> Iterator[tuple[Mission, Settings]]:
    """Clear days anywhere: places, seasons, winds, circles, lengths, rates, noise, clearness."""
    rng = np.random.default_rng(7)
    mission = load_mission("rafz-28h")
    for seed in range(count):
        longitude = rng.uniform(-180.0, 180.0)
        keys = {
            "latitude_deg": rng.uniform(-50.0, 55.0),
            "longitude_deg": longitude,
            "clearness": rng.uniform(0.85, 1.0),
            "wind_m_per_s": rng.uniform(0.0, 5.0),
            "wind_from_deg": rng.uniform(0.0, 360.0),
            "flight_path.radius_m": rng.uniform(40.0, 250.0),
            "flight_path.airspeed_m_per_s": rng.uniform(8.2, 12.0),
            "air.ambient_temperature_c": rng.normal(22.7, 6.0),
        }
        midnight = START_UTC_S // 86400.0 * 86400.0 + 86400.0 * int(rng.uniform(0.0, 365.0))
        start = midnight + 3600.0 * (rng.uniform(5.0, 10.0) - longitude / 15.0)
        settings = Settings(
            start_utc_s=float(start),
            duration_h=float(rng.uniform(4.0, 12.0)),
            rate_hz=float(rng.choice([0.02, 0.1, 0.2])),
            seed=seed,
            bias=float(rng.normal(0.0, 0.05)),
            jitter_deg=float(rng.uniform(0.5, 3.0)),
            power_noise_w=float(rng.uniform(0.5, 3.0)),
        )
        yield with_values(mission, {k: float(v) for k, v in keys.items()}), settings


def lying(log: FlightLog, ahead_s: float, turned_deg: float, factor: float = 1.0) -> FlightLog:
    """Log with errors of clock, heading and unit.

    Parameters
    ----------
    log : FlightLog
        A sound one.
    ahead_s, turned_deg : float
        How far its clock is ahead [s], its heading clockwise [deg].
    factor : float
        What its power is multiplied by.

    Returns
    -------
    FlightLog
    """
    attitude = log.attitude
    if attitude is not None:
        yaw = attitude.yaw_rad + np.radians(turned_deg)
        attitude = EulerAngles(attitude.roll_rad, attitude.pitch_rad, yaw)
    power = factor * log.solar_power_w
    return replace(log, time_s=log.time_s + ahead_s, attitude=attitude, solar_power_w=power)


@dataclass
class _Tally:
    days: int = 0
    anomalies: int = 0
    corrected: int = 0
    unknown: int = 0
    clock: tuple[float, ...] = ()
    heading: tuple[float, ...] = ()
    clock_sigmas: tuple[float, ...] = ()


def main() -> None:
    """Print the rates of false alarms and the errors of the estimates."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--days", type=int, default=200)
    days = parser.parse_args().days
    warnings.simplefilter("ignore")  # ranges of the models, which are not the subject
    aircraft, shipped = load_aircraft("atlantiksolar-as2"), load_mission("rafz-28h")
    geometry = aircraft.modules.geometry
    rng, tally = np.random.default_rng(1), _Tally()
    for where, settings in random_days(days):
        log = synthetic_log(aircraft, where, settings).log()
        known = with_values(shipped, {"latitude_deg": float(np.mean(where.latitudes()))})
        sound = verify(aircraft, log, known)
        tally.days += 1
        tally.anomalies += bool(sound.anomalies)
        tally.corrected += sound.corrected
        ahead, turned = float(rng.choice(CLOCKS_S)), float(rng.choice(HEADINGS_DEG))
        found = align(lying(log, ahead, turned), aircraft, known, geometry)
        if found.clock_ahead_s is None or found.heading_ahead_deg is None:
            tally.unknown += 1
            continue
        error = found.heading_ahead_deg.value - turned
        tally.clock += (found.clock_ahead_s.value - ahead,)
        tally.clock_sigmas += (found.clock_ahead_s.sigma,)
        tally.heading += ((error + 180.0) % 360.0 - 180.0,)
    clock, heading = np.abs(tally.clock), np.abs(tally.heading)
    lines = (
        f"clear days: {tally.days}",
        f"with an anomaly: {tally.anomalies}",
        f"with an error of the log: {tally.corrected}",
        f"injected errors without a number: {tally.unknown}",
        f"clock within 2 min: {np.mean(clock <= 120.0):.1%}, median {np.median(clock):.1f} s, "
        f"largest {clock.max():.0f} s, stated {np.median(tally.clock_sigmas):.0f} s",
        f"heading within 3 deg: {np.mean(heading <= 3.0):.1%}, "
        f"median {np.median(heading):.2f} deg, largest {heading.max():.2f} deg",
    )
    print("\n".join(lines))


if __name__ == "__main__":
    main()
