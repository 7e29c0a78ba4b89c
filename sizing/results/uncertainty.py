"""Analysis under uncertain inputs: how likely a flight is perpetual, and what that depends on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.results.design_result import check_subjects
from sizing.results.result import Result, data_frame, percentiles
from sizing.uncertainty.inputs import Proportion, UncertainInputs, sobol_points, uncertain_inputs
from sizing.uncertainty.propagation import Flights, Propagation, check_inputs, propagation_of
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.types import FloatArray

if TYPE_CHECKING:
    import pandas as pd

DEFAULT_SAMPLES = 8192
_OF_FRAME = ("excess_time_h", "minimum_state_of_charge", "total_mass_kg", "propulsion_power_w")
_LEAST_SAMPLES, _MOST_SAMPLES = 64, 2**20


@dataclass(frozen=True)
class SobolIndex:
    """Share of the variance that an input explains, alone and with all others together [-]."""

    first: float
    total: float


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

    renderer = "studies.uncertainty"

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

    @property
    def percentiles(self) -> dict[str, dict[str, float]]:
        """P90, P50 and P10 of excess time, state of charge and endurance."""
        return {key: percentiles(values) for key, values in self.scattered().items()}

    @property
    def spreads(self) -> list[dict[str, Any]]:
        """Inputs with the percentiles of their draws."""
        return [
            {
                "key": row.key,
                "nominal": row.nominal,
                "distribution": row.distribution.distribution,
                "percentiles": percentiles(self.values[row.key]),
            }
            for row in self.inputs.inputs
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each draw: inputs, excess time, least state of charge, mass, power."""
        return data_frame(self.values | {key: getattr(self.flights, key) for key in _OF_FRAME})

    def scattered(self) -> dict[str, FloatArray]:
        """Return excess time, state of charge and endurance of the draws."""
        return {
            "excess_time_h": self.flights.excess_time_h,
            "minimum_state_of_charge": self.flights.minimum_state_of_charge,
            "endurance_h": self.endurance_h,
        }

    @property
    def lobes(self) -> dict[str, NDArray[np.bool_]]:
        """Perpetual and limited draws; empty unless each of them is a tenth of all or more.

        What is between the two lobes, as a median of all is, need not be near any draw.
        """
        perpetual = self.flights.excess_time_h > 0.0
        share = float(np.mean(perpetual))
        two = _LEAST_LOBE <= share <= 1.0 - _LEAST_LOBE
        return {"perpetual": perpetual, "limited": ~perpetual} if two else {}


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
    study = propagation_of(aircraft, mission, solar)
    values = inputs.values(sobol_points(len(inputs), samples, seed))
    count = study.draws_of_endurance
    few = {key: value[:count] for key, value in values.items()}
    nominal = {row.key: np.array([row.nominal]) for row in inputs.inputs}
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
    """Return the indices of the excess time (Saltelli et al. 2010, Comput. Phys. Commun. 181).

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
        row.key: SobolIndex(float(f), float(t))
        for row, f, t in zip(inputs.inputs, first, total, strict=True)
    }


_LEAST_LOBE = 0.1  # of all draws
