"""Fit of an aircraft's parameters to flight logs."""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from scipy.linalg import block_diag

from missions.files.errors import file_error
from missions.library import load_mission
from missions.logs.csv import read_flight_log
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.results.tables import Column, Line, Result, Summary, Table
from solar.types import FloatArray
from studies.fitting.channels.battery import charge_channel, load_channel
from studies.fitting.channels.bins import BIN_S
from studies.fitting.channels.channel import Channel, Flown, joined
from studies.fitting.channels.solar import solar_channel
from studies.fitting.estimation import Estimate, Fitted, FoundError, Held, estimate, with_fitted
from studies.fitting.flight_tables import differences, error_table, flight_records, flight_table
from studies.fitting.least_squares import CONFIDENCE
from studies.fitting.parameters import ChannelName, chosen
from studies.flight_logs.verification import DEFAULT_MISSION, utc_label, verify

Log: TypeAlias = FlightLog | str | os.PathLike[str]

# The report's irradiance model and PV_LIB agree within 3 %; docs/validation.md compares more.
LIGHT_SIGMA = 0.03
_FEWEST_BINS = 12  # an hour


@dataclass(frozen=True, repr=False)
class FlightFit(Result):
    """Parameters of an aircraft, fitted to flight logs.

    Attributes
    ----------
    aircraft : Aircraft
        As its file describes it.
    mission : Mission
        In the place and air of the first log.
    logs : tuple of FlightLog
    estimates : tuple of Estimate
        One for each channel that the logs have.
    light_sigma : float
        Standard uncertainty of the level of the light, relative [-].
    notes : tuple of str
        What the reader should know.
    """

    aircraft: Aircraft
    mission: Mission
    logs: tuple[FlightLog, ...]
    estimates: tuple[Estimate, ...]
    missing: tuple[Held, ...]
    light_sigma: float
    notes: tuple[str, ...]

    @property
    def log(self) -> FlightLog:
        """First log."""
        return self.logs[0]

    @property
    def fitted(self) -> tuple[Fitted, ...]:
        """Parameters that were fitted, with their intervals."""
        return tuple(one for part in self.estimates for one in part.fitted)

    @property
    def held(self) -> tuple[Held, ...]:
        """Parameters that were asked for and not fitted, with the reasons."""
        return (*(one for part in self.estimates for one in part.held), *self.missing)

    def fitted_aircraft(self) -> Aircraft:
        """Aircraft with the fitted values."""
        return with_fitted(self.aircraft, self.fitted)

    def covariance(self) -> FloatArray:
        """Covariance of :attr:`fitted` in its order; different channels are independent."""
        size = len(self.fitted)
        return self.covariance_with_model()[:size, :size]

    def covariance_with_model(self) -> FloatArray:
        """Covariance of the fitted parameters, then of :attr:`model_errors`."""
        parameters, errors, first = list[int](), list[int](), 0
        for part in self.estimates:
            after = first + len(part.fitted)
            parameters += range(first, after)
            errors += (after + i for i in _of_the_model(part))
            first += len(part.solution.covariance)
        whole = block_diag(*(part.solution.covariance for part in self.estimates))
        order = parameters + errors
        return np.asarray(whole[np.ix_(order, order)])

    @property
    def model_errors(self) -> tuple[FoundError, ...]:
        """What is wrong with the model of the aircraft on all flights, as the fit has it."""
        return tuple(part.errors[i] for part in self.estimates for i in _of_the_model(part))

    def headline(self) -> str:
        """Aircraft, log, and how many parameters were fitted."""
        start, end = utc_label(self.log.time_s[0]), utc_label(self.log.time_s[-1])
        count, more = len(self.fitted), len(self.logs) - 1
        text = f"{count} parameter{'' if count == 1 else 's'} fitted, {len(self.held)} held"
        others = f" and {more} more flight{'' if more == 1 else 's'}" if more else ""
        return f"{self.aircraft.name} fitted to {self.log.source}{others}: {start} to {end}, {text}"

    def summary(self) -> Summary:
        """Headline, parameters, how well each channel is met, and notes."""
        blocks: list[Any] = [Line(self.headline(), "strong")]
        blocks += [table for table in self.tables() if table.rows]
        blocks += [
            Line(f"held: {one.parameter.name} at {one.value:g}: {one.reason}", "warning")
            for one in self.held
        ]
        blocks += differences(self.estimates)
        return Summary((*blocks, *(f"- {note}" for note in self.notes)))

    def tables(self) -> list[Table]:
        """Fitted parameters, what each flight adds, errors of the flights, and the channels."""
        columns = (
            Column("parameter"),
            Column("unit"),
            Column("before", form=".4g"),
            Column("value", "fitted", form=".4g"),
            Column("low", form=".4g"),
            Column("high", form=".4g"),
        )
        rows = tuple(
            (one.parameter.name, one.parameter.unit, one.before, one.value, one.low, one.high)
            for one in self.fitted
        )
        title = f"fitted parameters, {CONFIDENCE:.0%} intervals"
        names = [one.source for one in self.logs]
        flights = [flight_table(self.estimates, names), error_table(self.estimates, names)]
        return [Table(title, columns, rows), *flights, self._channel_table()]

    def _channel_table(self) -> Table:
        columns = (
            Column("channel"),
            Column("unit"),
            Column("bins", "means"),
            Column("independent", form=".1f", to_right=True),
            Column("rms_before", "RMS before", form=".3g"),
            Column("rms_after", "RMS after", form=".3g"),
            Column("collinearity", form=".1f"),
        )
        names = ("label", *(column.name for column in columns[1:]))
        records = map(_channel_record, self.estimates)
        rows = tuple(tuple(record[name] for name in names) for record in records)
        return Table(f"residuals, means over {BIN_S / 60.0:g} min", columns, rows)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the residuals, JSON-ready."""
        return {
            "aircraft": self.aircraft.name,
            "log": _log_record(self.log),
            "more_logs": [_log_record(log) for log in self.logs[1:]],
            "confidence": CONFIDENCE,
            "light_sigma": self.light_sigma,
            "fitted": [{"name": one.parameter.name, **one.to_dict()} for one in self.fitted],
            "held": [{"name": one.parameter.name, **one.to_dict()} for one in self.held],
            "channels": [_channel_record(part) for part in self.estimates],
            "notes": list(self.notes),
        }


def _of_the_model(part: Estimate) -> list[int]:
    return [i for i, one in enumerate(part.errors) if one.known.flight is None]


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _log_record(log: FlightLog) -> dict[str, Any]:
    ends = {"start": utc_label(log.time_s[0]), "end": utc_label(log.time_s[-1])}
    return {"source": log.source, **ends, "samples": len(log)}


def _channel_record(part: Estimate) -> dict[str, Any]:
    return {
        "channel": part.channel.name,
        "label": part.channel.label,
        "unit": part.channel.unit,
        "bins": len(part.before),
        # Nobody asks where nothing was fitted.
        "independent": part.solution.independent if part.fitted else None,
        "rms_before": _rms(part.before),
        "rms_after": _rms(part.solution.residual),
        "singular_values": part.solution.singular.tolist(),
        "collinearity": part.collinearity,
        "parameters": [one.parameter.name for one in part.fitted],
        "correlation": part.correlation().tolist(),
        **flight_records(part),
    }


def _channels(
    flown: Flown, aircraft: Aircraft, light_sigma: float
) -> dict[ChannelName, Channel | str]:
    """Channels that a log has, or why it does not have them.

    Each predicts from an aircraft alone, given what else was logged: the charge from the *measured*
    power and load, so that no error of one model is taken for another's.
    """
    made: dict[ChannelName, Channel | str] = {
        "solar": solar_channel(flown, aircraft, light_sigma),
        "load": load_channel(flown),
        "charge": charge_channel(flown),
    }
    for name, one in made.items():
        if isinstance(one, Channel) and len(one.measured) < _FEWEST_BINS:
            made[name] = f"{len(one.measured)} means over {BIN_S / 60:g} min are too few"
    return made


def fit_flight(
    aircraft: Aircraft,
    log: Log | Sequence[Log],
    mission: Mission | None = None,
    *,
    names: tuple[str, ...] = (),
    light_sigma: float = LIGHT_SIGMA,
    correct: bool | None = True,
) -> FlightFit:
    """Fit parameters of an aircraft to flight logs, with confidence intervals.

    Solar power, load and charge are fitted one by one, each by least squares over means of five
    minutes: modules to the solar power, level flight to the load, the battery to the charge that
    the measured power and load lead to.

    Parameters
    ----------
    aircraft : Aircraft
        Values to start from, and those of what is not fitted.
    log : FlightLog or path, or a sequence of them
        The flight or flights, or their files.
    mission : Mission, optional
        Clearness, payload, turbulence, and air that the log does not have; the shipped
        ``rafz-28h`` by default.
    names : tuple of str
        Parameters of :data:`studies.fitting.parameters.PARAMETERS`; by default module efficiency,
        temperature rise, level power and specific energy of the battery.
    light_sigma : float
        Standard uncertainty of the level of the light of each flight, relative [-].
    correct : bool or None
        Whether errors of the logs' clock, heading and unit are corrected, as by
        :func:`studies.flight_logs.verification.verify`; None: they are not looked for.

    Returns
    -------
    FlightFit

    Raises
    ------
    ValueError
        For a parameter that there is not.
    InputError
        If a log cannot be read, is given twice, or the sun never rises in it.
    """
    parameters = chosen(names, aircraft)
    given = (log,) if isinstance(log, FlightLog | str | os.PathLike) else tuple(log)
    logs = [one if isinstance(one, FlightLog) else read_flight_log(os.fspath(one)) for one in given]
    for first, other in itertools.combinations(logs, 2):
        alike = np.array_equal(first.time_s, other.time_s)
        if alike and np.array_equal(first.solar_power_w, other.solar_power_w):
            raise file_error(other.source, f"is the same flight as {first.source}: give it once")
    mission = load_mission(DEFAULT_MISSION) if mission is None else mission
    verified = [verify(aircraft, one, mission, correct=correct) for one in logs]
    flights = [Flown.of(one, mission) for one in verified]
    found = [_channels(one, aircraft, light_sigma) for one in flights]
    estimates, lacking = [], []
    for name in dict.fromkeys(one.channel for one in parameters):
        own = tuple(one for one in parameters if one.channel == name)
        every = {number: channels[name] for number, channels in enumerate(found)}
        parts = {number: one for number, one in every.items() if isinstance(one, Channel)}
        if parts:
            estimates.append(estimate(joined(parts), aircraft, own))
        else:
            lacking += [Held(one, one.value(aircraft), str(every[0])) for one in own]
    notes = [note for one in verified for note in one.log.notes]
    for one in verified:
        notes += [sentence for sentence, wrong in one.log_verdicts() if wrong]
        notes += () if one.diagnosis is None else one.diagnosis.notes
    notes += [note for part in estimates for note in part.channel.notes]
    if any(part.channel.name == "solar" and part.fitted for part in estimates):
        notes.append(
            "the intervals of the modules count errors of the clear sky (level "
            f"{100 * light_sigma:g} %, haze, diffuse light), of attitude and model: module and "
            "MPPT efficiency, area and clearness are one factor to a log"
        )
    return FlightFit(
        aircraft=aircraft,
        mission=flights[0].mission,
        logs=tuple(one.log for one in verified),
        estimates=tuple(estimates),
        missing=tuple(lacking),
        light_sigma=light_sigma,
        notes=tuple(dict.fromkeys(notes)),
    )
