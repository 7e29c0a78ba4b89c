"""A measured quantity of a flight and a model of it, in means over some minutes.

A loiter turns the modules through the light about once a minute: means over
:data:`~studies.fitting.channels.bins.BIN_S` know nothing of that, nor of most of the noise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from missions.logs.table import FlightLog
from missions.mission import AirConditions, Mission
from sizing.aircraft import Aircraft
from solar.types import FloatArray, IntArray
from studies.fitting.channels.flight_errors import FlightError
from studies.fitting.parameters import ChannelName
from studies.flight_logs.verification import Verification

Predict = Callable[[Aircraft], FloatArray]


@dataclass(frozen=True)
class Channel:
    """A measured quantity in bins, and a model of it.

    ``time_s``: mean time of each bin's samples [s since 1970, UTC]. ``run``: number of the
    uninterrupted stretch. ``predict``: modelled value of each bin, from an aircraft. ``floating``:
    whether only differences count: every stretch has a level of its own. ``notes``: what was left
    out. ``errors``: of the flights, known within their standard deviations. ``sizes``,
    ``numbers``: bins of each flight, and which flight it is.
    """

    name: ChannelName
    label: str
    unit: str
    time_s: FloatArray
    measured: FloatArray
    run: IntArray
    predict: Predict
    floating: bool = False
    notes: tuple[str, ...] = ()
    errors: tuple[FlightError, ...] = ()
    sizes: tuple[int, ...] = ()
    numbers: tuple[int, ...] = (0,)

    @cached_property
    def flights(self) -> tuple[slice, ...]:
        """Bins of each flight."""
        ends = np.cumsum(self.sizes or (len(self.measured),)).tolist()
        return tuple(slice(a, b) for a, b in zip((0, *ends), ends, strict=False))

    @cached_property
    def slopes(self) -> FloatArray:
        """Relative change of each bin per unit of each error, shape (bin, error)."""
        columns = [one.slope for one in self.errors]
        return np.stack(columns, axis=1) if columns else np.zeros((len(self.measured), 0))

    def with_errors(self, modelled: FloatArray, errors: FloatArray | None) -> FloatArray:
        """Modelled values with errors of the flights."""
        return modelled if errors is None else modelled * np.exp(self.slopes @ errors)

    def apart(self, modelled: FloatArray, errors: FloatArray | None = None) -> FloatArray:
        """Measured less modelled; of a floating channel without the mean of each stretch."""
        left = self.measured - self.with_errors(modelled, errors)
        return self.centred(left) if self.floating else left

    def residual(self, aircraft: Aircraft) -> FloatArray:
        """Measured less modelled by an aircraft."""
        return self.apart(self.predict(aircraft))

    def centred(self, values: FloatArray) -> FloatArray:
        """Values without the mean of each stretch."""
        counts = np.bincount(self.run)
        means = np.bincount(self.run, values) / np.maximum(counts, 1)
        return np.asarray(values - means[self.run])


def joined(flights: Mapping[int, Channel]) -> Channel:
    """Channel of several flights, by their numbers: errors and stretches of their own."""
    parts, runs, notes = tuple(flights.values()), list[IntArray](), list[str]()
    sizes = tuple(len(one.measured) for one in parts)
    errors: dict[tuple[str, int | None], FlightError] = {}
    for place, (number, one) in enumerate(flights.items()):
        before, after = sum(sizes[:place]), sum(sizes[place + 1 :])
        for error in one.errors:
            slope = np.concatenate((np.zeros(before), error.slope, np.zeros(after)))
            of = None if error.flight is None else number
            known = errors.setdefault(
                (error.name, of), replace(error, slope=0.0 * slope, flight=of)
            )
            errors[error.name, of] = replace(known, slope=known.slope + slope)
        runs.append(one.run + (int(runs[-1][-1]) + 1 if runs else 0))
        named = f"flight {number + 1}: " if number or len(parts) > 1 else ""
        notes += [f"{named}{note}" for note in one.notes]
    return replace(
        parts[0],
        time_s=np.concatenate([one.time_s for one in parts]),
        measured=np.concatenate([one.measured for one in parts]),
        run=np.concatenate(runs),
        predict=lambda aircraft: np.concatenate([one.predict(aircraft) for one in parts]),
        notes=tuple(notes),
        errors=tuple(errors.values()),
        sizes=sizes,
        numbers=tuple(flights),
    )


@dataclass(frozen=True)
class Flown:
    """A log, the mission in its place and air, and which samples may be used."""

    log: FlightLog
    mission: Mission
    found: Verification

    @classmethod
    def of(cls, verification: Verification, mission: Mission) -> Flown:
        """Mission at the mean place and air of a log, without launch and climb; not validated."""
        log, air = verification.log, mission.air
        place = {
            "latitude_deg": float(np.median(log.latitude_deg)),
            "longitude_deg": float(np.median(log.longitude_deg)),
            "altitude_m": float(np.median(log.altitude_m)),
        }
        if log.ambient_temperature_c is not None:
            mean_c = float(np.nanmean(log.ambient_temperature_c))
            air = AirConditions(
                ambient_temperature_c=mean_c, module_temperature_c=air.module_temperature_c
            )
        known = {**place, "launch": None, "climb": None, "air": air}
        return cls(log, mission.model_copy(update=known), verification)


def ambient_c(flown: Flown, index: IntArray) -> FloatArray:
    """Air temperature at samples of a log: logged, else of the mission."""
    mean_c = float(flown.mission.air_state().temperature_c)
    logged = flown.log.ambient_temperature_c
    if logged is None:
        return np.full(len(index), mean_c)
    return np.where(np.isnan(logged[index]), mean_c, logged[index])
