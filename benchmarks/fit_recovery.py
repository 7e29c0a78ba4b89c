"""How often a fit's interval holds the truth, and how well another flight is predicted.

``python -m benchmarks.fit_recovery --count 100`` flies as many synthetic aircraft, each
with its own modules, drag and battery, fits them from the shipped file, and predicts two other
flights of each: the least charge of a night in July, and the time to the empty battery in December.
With ``--independent`` the flights are those of :mod:`benchmarks.independent_flights`, under another
sky each, and the least charge of one other flight is predicted.
"""

from __future__ import annotations

import argparse
import math
import warnings
from dataclasses import dataclass
from functools import partial
from multiprocessing import Pool

import numpy as np

from benchmarks.independent_flights import drawn_cells, true_values
from benchmarks.independent_flights import flown as flown_independently
from missions.library import load_mission
from missions.logs.table import log_from_table
from sizing.library import load_aircraft
from sizing.results.tables import Column, Line, Result, Summary, Table
from solar.types import FloatArray
from studies.fitting.flight import fit_flight
from studies.fitting.parameters import PARAMETERS, default_names, replaced_values
from studies.fitting.prediction import predict_flight
from studies.fitting.synthetic import Errors, Flight, fly

AIRCRAFT, MISSION = "atlantiksolar-as2", "rafz-28h"
# Standard deviations of the truth around the shipped file, relative; assumption.
_SPREAD = {
    "module_efficiency": 0.05,
    "temperature_rise": 0.3,
    "level_power": 0.10,
    "specific_energy": 0.08,
}
_ERRORS = Errors(haze=0.01)
_FITTED = Flight(duration_h=52.0, errors=_ERRORS)
_JULY_UTC_S = 1436859120.0  # 14 July 2015, 07:32: the launch of the 81 h flight
_DECEMBER_UTC_S = 1449302400.0  # 5 December 2015, 08:00
_LEAST = 0.1  # of the file's value: below, a draw is no aircraft


@dataclass(frozen=True)
class Case:
    """One aircraft: by parameter truth and, where fitted, value and interval; and predictions.

    ``errors`` has the errors of each predicted quantity with the file's values and with the fitted
    ones, and its standard error.
    """

    truth: dict[str, float]
    fitted: dict[str, tuple[float, float, float]]
    errors: dict[str, tuple[float, float, float]]


@dataclass(frozen=True, repr=False)
class Recovery(Result):
    """Fits of synthetic flights beside their truth."""

    cases: tuple[Case, ...]
    confidence: float

    def covered(self, name: str) -> tuple[int, int]:
        """In how many cases an interval holds the truth, and in how many there is one."""
        held = [
            case.fitted[name][1] <= case.truth[name] <= case.fitted[name][2]
            for case in self.cases
            if name in case.fitted
        ]
        return sum(held), len(held)

    def all_covered(self) -> tuple[int, int]:
        """The same over all parameters."""
        hits, counts = zip(*(self.covered(name) for name in _SPREAD), strict=True)
        return sum(hits), sum(counts)

    def headline(self) -> str:
        """Coverage over all parameters, with its binomial uncertainty."""
        hits, count = self.all_covered()
        share, sigma = _share(hits, count)
        return (
            f"{len(self.cases)} flights: {hits} of {count} intervals of {self.confidence:.0%} hold "
            f"the truth, {100 * share:.1f} ± {100 * sigma:.1f} %"
        )

    def summary(self) -> Summary:
        """Headline, coverage of each parameter, and predictions."""
        return Summary((Line(self.headline(), "strong"), self.table(), self.prediction_table()))

    def table(self) -> Table:
        """Coverage and errors of each parameter."""
        columns = (
            Column("parameter"),
            Column("fitted", "cases"),
            Column("covered", "covered [%]", form=".1f"),
            Column("sigma", "±", form=".1f"),
            Column("before", "RMS error before [%]", form=".1f"),
            Column("after", "RMS error fitted [%]", form=".1f"),
            Column("half_width", "median half-width [%]", form=".1f"),
        )
        return Table("parameters", columns, tuple(self._row(name) for name in _SPREAD))

    def _row(self, name: str) -> tuple[str | float | None, ...]:
        shipped = PARAMETERS[name].value(load_aircraft(AIRCRAFT))
        fitted = [case for case in self.cases if name in case.fitted]
        hits, count = self.covered(name)
        share, sigma = _share(hits, count)
        if not count:
            return name, 0, None, None, None, None, None
        truth = np.array([case.truth[name] for case in fitted])
        value, low, high = np.array([case.fitted[name] for case in fitted]).T
        half_width = float(np.median(0.5 * (high - low)))
        sizes = (_rms(shipped - truth), _rms(value - truth), half_width)
        relative = [100.0 * size / shipped for size in sizes]
        return name, count, 100.0 * share, 100.0 * sigma, *relative

    def prediction_table(self) -> Table:
        """Errors of what was predicted of other flights."""
        columns = (
            Column("quantity"),
            Column("cases"),
            Column("before", "RMS error before", form=".2f"),
            Column("after", "RMS error fitted", form=".2f"),
            Column("bias", "mean error fitted", form="+.2f"),
            Column("stated", "stated", form=".2f"),
            Column("z", "RMS of error over stated", form=".2f"),
        )
        rows = []
        for quantity in dict.fromkeys(name for case in self.cases for name in case.errors):
            known = [case.errors[quantity] for case in self.cases if quantity in case.errors]
            if known:
                before, after, stated = np.array(known).T
                sizes = (_rms(before), _rms(after), float(np.mean(after)), _rms(stated))
                rows.append((quantity, len(known), *sizes, _rms(after / stated)))
        return Table("other flights, predicted", columns, tuple(rows))


def _share(hits: int, count: int) -> tuple[float, float]:
    """Share, and its standard deviation by the binomial distribution."""
    if not count:
        return math.nan, math.nan
    share = hits / count
    return share, math.sqrt(share * (1.0 - share) / count)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def recover(
    count: int,
    *,
    seed: int = 0,
    predict: bool = True,
    independent: int = 0,
    workers: int = 1,
) -> Recovery:
    """Fit synthetic flights of aircraft whose truth is known.

    Parameters
    ----------
    count : int
        Number of aircraft.
    seed : int
        Of the first; each has its own.
    predict : bool
        Whether other flights are predicted as well.
    independent : int
        Flights of each aircraft that are fitted together, by the independent simulation; 0 for one
        flight under the project's own sky.
    workers : int
        Processes.

    Returns
    -------
    Recovery
    """
    from studies.fitting.least_squares import CONFIDENCE

    one = partial(_independent_case, flights=independent) if independent else _case
    run = partial(one, predict=predict)
    seeds = range(seed, seed + count)
    if workers == 1:
        return Recovery(tuple(map(run, seeds)), CONFIDENCE)
    with Pool(workers) as pool:
        return Recovery(tuple(pool.map(run, seeds, chunksize=1)), CONFIDENCE)


def _independent_case(seed: int, predict: bool, flights: int) -> Case:
    warnings.simplefilter("ignore")  # ranges of the models, which are not the subject
    aircraft, mission = load_aircraft(AIRCRAFT), load_mission(MISSION)
    names = ("module_efficiency", "level_power", "specific_energy")
    parameters = tuple(PARAMETERS[name] for name in names)
    rng = np.random.default_rng([seed, 2])
    drawn = [
        (1.0 + _SPREAD[one.name] * rng.standard_normal()) * one.value(aircraft)
        for one in parameters
    ]
    truth, cells = replaced_values(aircraft, parameters, tuple(drawn)), drawn_cells(rng)
    logs = [
        log_from_table(flown_independently(truth, cells, 100 * seed + number).rows, f"{number}.csv")
        for number in range(flights)
    ]
    fit = fit_flight(aircraft, logs, mission, correct=None)
    errors: dict[str, tuple[float, float, float]] = {}
    if predict:
        other = flown_independently(truth, cells, 100 * seed + 50)
        log = log_from_table(other.rows, "other.csv")
        found = predict_flight(fit, log, mission, correct=None)
        minima = (found.before.minimum_charge, found.after.minimum_charge)
        apart = [100.0 * (value - other.minimum_charge) for value in minima]
        errors["minimum charge [%]"] = (apart[0], apart[1], 100.0 * found.minimum_charge_error)
    fitted = {one.parameter.name: (one.value, one.low, one.high) for one in fit.fitted}
    return Case(true_values(truth, cells), fitted, errors)


def _case(seed: int, predict: bool) -> Case:
    aircraft, mission = load_aircraft(AIRCRAFT), load_mission(MISSION)
    names = default_names(aircraft)
    chosen = tuple(PARAMETERS[name] for name in names)
    rng = np.random.default_rng([seed, 1])
    factors = np.maximum([1.0 + _SPREAD[n] * rng.standard_normal() for n in names], _LEAST)
    values = tuple(float(f) * one.value(aircraft) for f, one in zip(factors, chosen, strict=True))
    truth = replaced_values(aircraft, chosen, values)

    def flown(flight: Flight, number: int) -> Flight:
        return Flight(**{**vars(flight), "seed": 10 * seed + number})

    # The clocks of these logs are right: to look for their errors takes most of the time.
    fit = fit_flight(aircraft, fly(truth, mission, flown(_FITTED, 1)).log(), mission, correct=None)
    fitted = {one.parameter.name: (one.value, one.low, one.high) for one in fit.fitted}
    errors: dict[str, tuple[float, float, float]] = {}
    if predict:
        july = Flight(_JULY_UTC_S, 30.0, 0.5, errors=_ERRORS)
        night = fly(truth, mission, flown(july, 2))
        found = predict_flight(fit, night.log("july.csv"), mission, correct=None)
        minima = (found.before.minimum_charge, found.after.minimum_charge)
        apart = [100.0 * (value - night.minimum_charge) for value in minima]
        stated = 100.0 * found.minimum_charge_error
        errors["minimum charge, July [%]"] = (apart[0], apart[1], stated)
        december = Flight(_DECEMBER_UTC_S, 40.0, 0.5, errors=_ERRORS)
        last = fly(truth, mission, flown(december, 3))
        found = predict_flight(fit, last.log("december.csv"), mission, correct=None)
        if None not in (last.empty_h, found.before.empty_h, found.after.empty_h):
            before, after = (
                float(one.empty_h or 0.0) - float(last.empty_h or 0.0)
                for one in (found.before, found.after)
            )
            errors["time to empty, December [h]"] = (before, after, found.empty_error_h or 0.0)
    return Case(dict(zip(names, values, strict=True)), fitted, errors)


def main() -> None:
    """Print the recovery of so many synthetic flights."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="aircraft to fly and fit")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--no-prediction", action="store_true", help="fit alone")
    parser.add_argument(
        "--independent", type=int, default=0, metavar="N", help="fit N independent flights together"
    )
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    found = recover(
        given.count,
        seed=given.seed,
        predict=not given.no_prediction,
        independent=given.independent,
        workers=given.workers,
    )
    print(found)


if __name__ == "__main__":
    main()
