"""Analysis under uncertain inputs: how likely a flight is perpetual, and what that depends on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.results.notes import extrapolation_blocks
from sizing.results.quantities import DRAWN, ENDURANCE, EXCESS_TIME, MINIMUM_CHARGE, Quantity
from sizing.results.records import check_subjects, hours, percentiles
from sizing.results.tables import Column, Line, Result, Summary, Table, data_frame, facts
from sizing.uncertainty.inputs import Proportion, UncertainInputs, sobol_points, uncertain_inputs
from sizing.uncertainty.propagation import Flights, Propagation, check_inputs
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.types import FloatArray

if TYPE_CHECKING:
    import pandas as pd

DEFAULT_SAMPLES = 8192
_LEAST_SAMPLES, _MOST_SAMPLES = 64, 2**20
# Draws whose endurance is searched for: a launch of each is refined.
_ENDURANCE_SAMPLES, _CLIMBING_ENDURANCE_SAMPLES = 1024, 256


@dataclass(frozen=True)
class SobolIndex:
    """Share of the variance that an input explains, alone and with all others together [-]."""

    first: float
    total: float


class DrawnInput(NamedTuple):
    """An uncertain input, with the percentiles of its draws."""

    key: str
    nominal: float
    distribution: str
    percentiles: dict[str, float]


@dataclass(frozen=True, repr=False, eq=False)
class UncertaintyAnalysis(Result):
    """Flights under draws of the uncertain inputs.

    Attributes
    ----------
    aircraft, mission
        As their files give them.
    solar : SolarModel
    inputs : UncertainInputs
    values : dict
        Values of every input by its key, shape ``(sample,)``.
    flights : Flights
        What became of the draws.
    endurance_h : ndarray
        Longest flight of the first draws [h], infinite if perpetual.
    sobol : dict
        Indices of the excess time by input; empty where inputs are correlated.
    nominal_excess_time_h : float
        Excess time with every input as the files give it [h].
    required_h : float
        Excess time that the mission asks for [h].
    seed : int
    extrapolations : tuple of Extrapolation
        What the draws take from outside the range of a model.
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    inputs: UncertainInputs
    values: dict[str, FloatArray]
    flights: Flights
    endurance_h: FloatArray
    sobol: dict[str, SobolIndex]
    nominal_excess_time_h: float
    required_h: float
    seed: int
    extrapolations: tuple[Extrapolation, ...] = ()

    @property
    def samples(self) -> int:
        """Number of draws."""
        return len(self.flights.excess_time_h)

    @cached_property
    def probability_perpetual(self) -> Proportion:
        """Probability of perpetual flight in every scenario."""
        return Proportion.of(self.flights.excess_time_h > 0.0)

    @cached_property
    def probability_required(self) -> Proportion:
        """Probability of the required excess time in every scenario."""
        excess = self.flights.excess_time_h
        return Proportion.of((excess > 0.0) & (excess >= self.required_h))

    def headline(self) -> str:
        """Aircraft, mission and probability in one line."""
        return (
            f"{self.aircraft.name} on {self.mission.name}: perpetual flight in "
            f"{100 * self.probability_perpetual.value:.1f} % of {self.samples} draws"
        )

    @property
    def percentiles(self) -> dict[Quantity, dict[str, float]]:
        """P90, P50 and P10 of excess time, state of charge and endurance."""
        return {one: _percentiles(values) for one, values in self._scattered().items()}

    @property
    def spreads(self) -> tuple[DrawnInput, ...]:
        """Inputs with the percentiles of their draws."""
        return tuple(
            DrawnInput(
                one.key,
                one.nominal,
                one.distribution.distribution,
                _percentiles(self.values[one.key]),
            )
            for one in self.inputs.inputs
        )

    def to_frame(self) -> pd.DataFrame:
        """A row a draw: its inputs, excess time, least state of charge, mass and power."""
        return data_frame(
            self.values | {one.name: getattr(self.flights, one.name) for one in DRAWN}
        )

    def _scattered(self) -> dict[Quantity, FloatArray]:
        known = vars(self.flights) | {ENDURANCE.name: self.endurance_h}
        return {one: known[one.name] for one in (EXCESS_TIME, MINIMUM_CHARGE, ENDURANCE)}

    def summary(self) -> Summary:
        """What the terminal shows."""
        rows = [("probability of perpetual flight", self.probability_perpetual.text())]
        if self.required_h > 0.0:
            label = f"probability of {self.required_h:g} h of excess time"
            rows.append((label, self.probability_required.text()))
        rows += [
            ("excess time with the files' values", hours(self.nominal_excess_time_h)),
            *self._spread_rows(),
        ]
        blocks: list[Any] = [Line(self.headline(), "strong"), facts("", rows), self.input_table()]
        blocks += extrapolation_blocks(self.extrapolations)
        climbs = f"; {self.mission.climb_label}" if self.mission.climb else ""
        text = f"{self.solar.label}{climbs}; seed {self.seed}. P90 is exceeded in 90 % of draws."
        if not self.inputs.independent:
            text += " Inputs are correlated: shares of the variance are not defined."
        blocks.append(Line(text, "faint"))
        return Summary(tuple(blocks))

    @property
    def lobes(self) -> dict[str, NDArray[np.bool_]]:
        """Perpetual and limited draws; empty unless each of them is a tenth of all or more.

        What is between the two lobes, as a median of all is, need not be near any draw.
        """
        perpetual = self.flights.excess_time_h > 0.0
        share = float(np.mean(perpetual))
        two = _LEAST_LOBE <= share <= 1.0 - _LEAST_LOBE
        return {"perpetual": perpetual, "limited": ~perpetual} if two else {}

    def _spread_rows(self) -> list[tuple[str, str]]:
        """Spread of excess time, endurance and state of charge; of two lobes each by itself."""
        scattered, lobes = self._scattered(), self.lobes
        if not lobes:
            return [
                ("excess time: P90, P50, P10 of draws", _three(EXCESS_TIME, scattered)),
                *((one.label, _three(one, scattered)) for one in (ENDURANCE, MINIMUM_CHARGE)),
            ]
        rows = []
        for name, varied in (("perpetual", MINIMUM_CHARGE), ("limited", ENDURANCE)):
            chosen = lobes[name]
            within = {one: values[chosen[: len(values)]] for one, values in scattered.items()}
            share = f"{name}, {100.0 * np.mean(chosen):.1f} % of draws"
            rows.append((f"{share}: excess time, P90, P50, P10", _three(EXCESS_TIME, within)))
            rows.append((f"{share}: {varied.label}", _three(varied, within)))
        return rows

    def input_table(self) -> Table:
        """Inputs with their spread and their shares of the excess time's variance."""
        order = sorted(
            self.inputs.inputs,
            key=lambda one: -self.sobol[one.key].total if one.key in self.sobol else 0.0,
        )
        rows = []
        for one in order:
            low, high = np.percentile(self.values[one.key], [10.0, 90.0])
            index = self.sobol.get(one.key)
            rows.append(
                (
                    one.label,
                    f"{one.nominal:.4g}",
                    f"{low:.4g} to {high:.4g}",
                    None if index is None else 100.0 * index.first,
                    None if index is None else 100.0 * index.total,
                )
            )
        columns = (
            Column("input"),
            Column("nominal"),
            Column("spread", "10 to 90 %"),
            Column("first", "of the variance, alone", "%", ".0f"),
            Column("total", "with others", "%", ".0f"),
        )
        return Table("what the excess time depends on", columns, tuple(rows))


def analyse_uncertainty(
    aircraft: Aircraft,
    mission: Mission,
    *,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    samples: int = DEFAULT_SAMPLES,
    seed: int = 0,
    model_error: bool = True,
) -> UncertaintyAnalysis:
    """Fly an aircraft under draws of the inputs that its file and the mission's call uncertain.

    Parameters
    ----------
    aircraft, mission
        With their ``uncertainty``.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.
    samples : int
        Draws, points of a scrambled Sobol sequence: 64 to 1,048,576, rounded up to a power of two.
    seed : int
        The same seed gives the same draws.
    model_error : bool
        Whether the RMS error of the solar model, after its correction, is an input as well.

    Returns
    -------
    UncertaintyAnalysis

    Raises
    ------
    InputError
        For inputs that are no numbers of the files, spreads that make a value impossible, and
        correlations that contradict each other.
    TypeError
        For what is no aircraft or mission.
    ValueError
        For an unknown model, a number of samples out of range, no uncertain input at all, or one
        that cannot be varied.
    """
    check_subjects(aircraft, mission)
    if not _LEAST_SAMPLES <= samples <= _MOST_SAMPLES:
        raise ValueError(
            f"samples must be from {_LEAST_SAMPLES} to {_MOST_SAMPLES} (got {samples})"
        )
    solar = SolarModel(model, correction)
    inputs = uncertain_inputs(aircraft, mission, solar, model_error=model_error)
    if not len(inputs):
        raise ValueError(
            f"neither {aircraft.name} nor {mission.name} has an uncertain input: give them "
            "uncertainty.inputs"
        )
    check_inputs(inputs, mission, solar)
    study = Propagation(aircraft, mission, solar)
    values = inputs.values(sobol_points(len(inputs), samples, seed))
    count = _CLIMBING_ENDURANCE_SAMPLES if mission.climb else _ENDURANCE_SAMPLES
    few = {key: value[:count] for key, value in values.items()}
    nominal = {one.key: np.array([one.nominal]) for one in inputs.inputs}
    flights = study.flights(values)
    return UncertaintyAnalysis(
        aircraft=aircraft,
        mission=mission,
        solar=solar,
        inputs=inputs,
        values=values,
        flights=flights,
        endurance_h=study.endurance_h(few, flights.first(count)),
        sobol=_sobol_indices(study, inputs, samples, seed) if inputs.independent else {},
        nominal_excess_time_h=float(study.flights(nominal).excess_time_h[0]),
        required_h=mission.required_excess_time_h,
        seed=seed,
        extrapolations=study.extrapolations(values, flights),
    )


def _sobol_indices(
    study: Propagation, inputs: UncertainInputs, samples: int, seed: int
) -> dict[str, SobolIndex]:
    """Indices of the excess time (Saltelli et al. 2010, Computer Physics Communications 181).

    Unlimited excess time counts as the largest finite one.
    """
    from scipy.stats import sobol_indices, uniform

    def excess(shares: FloatArray) -> FloatArray:
        excess_h = study.flights(inputs.values(shares)).excess_time_h
        known = np.isfinite(excess_h)
        return np.where(known, excess_h, np.max(excess_h[known], initial=0.0))

    if len(inputs) == 1:  # the whole variance is its own
        return {inputs.inputs[0].key: SobolIndex(1.0, 1.0)}
    each = max(2 ** int(math.log2(samples / (len(inputs) + 2))), 16)
    shares: Any = [uniform()] * len(inputs)
    indices = sobol_indices(func=excess, n=each, dists=shares, rng=seed)
    first, total = (np.nan_to_num(np.ravel(v)) for v in (indices.first_order, indices.total_order))
    return {
        one.key: SobolIndex(float(f), float(t))
        for one, f, t in zip(inputs.inputs, first, total, strict=True)
    }


_LEAST_LOBE = 0.1  # of all draws


def _percentiles(values: FloatArray) -> dict[str, float]:
    """P90, P50 and P10, each a draw that occurred."""
    return percentiles(values, "inverted_cdf")


def _three(quantity: Quantity, values: dict[Quantity, FloatArray]) -> str:
    found = _percentiles(values[quantity]).values()
    return ", ".join(quantity.fact(one)[1] for one in found)
