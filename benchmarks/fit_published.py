"""What the published figures of one flight say about the aircraft, and about another flight.

``python -m benchmarks.fit_published`` takes the level power of AtlantikSolar AS-2 from the
night of its 28 h flight, fits usable energy and module efficiency to two states of charge of that
flight, and predicts the figures of the 81 h flight. No log of either is published: there are no
residuals, so there are no intervals; temperature and MPPT cannot be fitted to five numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from sizing.results.tables import Column, Line, Result, Summary, Table
from solar.types import FloatArray
from studies.fitting.parameters import PARAMETERS, replaced_values
from studies.validation.flights.published_flights import FLIGHTS, Flight, Quantity, Trial

FLIGHT_28H = FLIGHTS["as2-28h"]
NIGHT_LOAD_W = 43.0  # published mean of the night, FLIGHT_28H
_FITTED = ("specific_energy", "module_efficiency")
_TO = ("minimum state of charge", "state of charge after 24 h")


@dataclass(frozen=True, repr=False)
class PublishedFit(Result):
    """Parameters from figures of the 28 h flight, and figures computed with them.

    ``rows`` has flight, quantity, unit, published, computed before and after, and what it is for.
    """

    parameters: Table
    figures: Table
    collinearity: float

    def headline(self) -> str:
        """What was fitted to what."""
        return (
            "AtlantikSolar AS-2: level power, usable energy and module efficiency from figures of "
            f"the 28 h flight; collinearity index {self.collinearity:.1f}"
        )

    def summary(self) -> Summary:
        """Headline, parameters, figures."""
        return Summary((Line(self.headline(), "strong"), self.parameters, self.figures))


def fit_published() -> PublishedFit:
    """Fit three numbers of the aircraft to three figures of a flight, and predict another."""
    chosen = tuple(PARAMETERS[name] for name in _FITTED)
    shipped = FLIGHT_28H.trial()
    loaded = shipped.with_load(NIGHT_LOAD_W)
    start = np.array([one.value(shipped.aircraft) for one in chosen])
    wanted = [FLIGHT_28H.quantity(name) for name in _TO]

    def apart(scale: FloatArray) -> FloatArray:
        trial = _changed(FLIGHT_28H, start * scale)
        return np.array([one.compute(trial) - one.published for one in wanted])

    found = least_squares(apart, np.ones(2), bounds=(0.5, 1.5), diff_step=[1e-3, 1e-3])
    jacobian = np.asarray(found.jac, float)
    columns = jacobian / np.sqrt(np.sum(jacobian**2, axis=0))
    values = start * found.x
    craft = loaded.aircraft.airframe
    level_w = craft.level_flight.electric_power_w  # type: ignore[union-attr]  # a measured aircraft
    before = PARAMETERS["level_power"].value(shipped.aircraft)
    rows = [("level_power", "W", before, level_w)]
    rows += [
        (one.name, one.unit, float(old), float(new))
        for one, old, new in zip(chosen, start, values, strict=True)
    ]
    return PublishedFit(
        parameters=Table(
            "parameters",
            (
                Column("parameter"),
                Column("unit"),
                Column("before", form=".4g"),
                Column("after", "fitted", form=".4g"),
            ),
            tuple(rows),
        ),
        figures=_figures(values),
        collinearity=1.0 / float(np.linalg.svd(columns, compute_uv=False).min()),
    )


def _changed(flight: Flight, values: FloatArray) -> Trial:
    """Flight of the aircraft with the night's load and the fitted values."""
    trial = flight.trial()
    level = FLIGHT_28H.trial().with_load(NIGHT_LOAD_W).aircraft
    chosen = (PARAMETERS["level_power"], *(PARAMETERS[name] for name in _FITTED))
    power_w = chosen[0].value(level)
    craft = replaced_values(trial.aircraft, chosen, (power_w, *values.tolist()))
    return Trial(craft, trial.mission, trial.solar)


def _figures(values: FloatArray) -> Table:
    columns = (
        Column("flight"),
        Column("quantity"),
        Column("published", form=".2f"),
        Column("before", form=".2f"),
        Column("after", "fitted", form=".2f"),
        Column("use"),
    )
    rows = []
    for name, flight in (
        ("28 h", FLIGHT_28H),
        ("81 h", FLIGHTS["as2-81h"]),
        ("81 h", FLIGHTS["as2-81h-clock"]),
    ):
        before, after = flight.trial(), _changed(flight, values)
        for one in flight.quantities:
            use = "fitted to" if flight is FLIGHT_28H and one.name in _TO else "predicted"
            rows.append(
                (
                    name,
                    _quantity_name(one),
                    one.published,
                    one.compute(before),
                    one.compute(after),
                    use,
                )
            )
    return Table("figures", columns, tuple(rows))


def _quantity_name(quantity: Quantity) -> str:
    return f"{quantity.name} [{quantity.unit}]"


if __name__ == "__main__":
    print(fit_published())
