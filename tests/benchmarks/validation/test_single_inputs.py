"""Single inputs that would explain a difference from a flight."""

import pytest

from benchmarks.validation import published_flights
from benchmarks.validation.flight_inputs import INPUTS, MISSES, Miss, Spread
from benchmarks.validation.single_inputs import explain

# The season takes a year of days for each value; it is computed for the documentation's table.
QUICK = MISSES[:2]


@pytest.fixture(scope="module")
def found():
    return explain(QUICK)


def needed(found, miss, name):
    return next(n for n in found[miss].needed if n.spread.input.name == name)


def test_uncertainty_of_a_range_is_that_of_an_even_distribution():
    # JCGM 100:2008, 4.3.7: half the width over the square root of 3.
    assert Spread(INPUTS["load"], 35.0, 46.0, "").standard_uncertainty == pytest.approx(
        5.5 / 3**0.5
    )
    assert Spread(INPUTS["load"], 35.0, 46.0, "", 2.0).standard_uncertainty == 2.0


def test_needed_values_give_the_published_number(found):
    for row in found:
        trial = row.miss.flight.trial()
        for n in row.needed:
            if n.needed is not None:
                computed = row.miss.quantity.compute(n.spread.input.change(trial, n.needed))
                assert computed == pytest.approx(row.miss.quantity.published, rel=2e-3)


def test_one_night_of_atlantiksolar_wants_less_power_and_one_more(found):
    of_81h, of_28h = (needed(found, i, INPUTS["load"].name) for i in (0, 1))
    assert of_81h.needed < of_81h.used < of_28h.needed
    assert of_81h.within and of_28h.within  # noqa: PT018
    # That one value also meets the other two numbers of its flight is no choice of ours.
    assert of_81h.others["minimum state of charge"] == pytest.approx(39.0, abs=0.2)
    assert of_81h.others["charge margin"] == pytest.approx(6.2, abs=0.1)


def test_light_and_efficiency_scale_the_power_alike(found):
    clearness, modules = (needed(found, 1, INPUTS[i].name) for i in ("clearness", "modules"))
    assert clearness.needed / clearness.used == pytest.approx(modules.needed / modules.used)
    trial = QUICK[1].flight.trial()
    computed = [
        QUICK[1].quantity.compute(n.spread.input.change(trial, n.needed or 0.0))
        for n in (clearness, modules)
    ]
    assert computed[0] == pytest.approx(computed[1], rel=1e-9)


def test_all_inputs_together_lead_towards_the_published_number(found):
    for row in found:
        published = row.miss.quantity.published
        assert (row.together - row.computed) * (published - row.computed) > 0.0


def test_impossible_number_has_no_explanation():
    flight = published_flights.FLIGHTS["sky-sailor-27h"]
    spread = Spread(INPUTS["temperature"], 10.0, 32.0, "a test")
    (row,) = explain((Miss(flight, flight.quantities[0], (spread,)),))
    (n,) = row.needed
    assert (n.needed, n.sigmas, n.within, n.others) == (None, None, False, {})


def test_every_range_has_a_source():
    for miss in MISSES:
        for spread in miss.spreads:
            assert spread.source
            assert spread.low < spread.high
