"""Strings within the window of their MPPT, held against every number of cells one by one."""

import pytest
from pydantic import ValidationError

from sizing.layout.strings import Strings

# SunPower C60, bin J (data sheet of November 2010).
C60 = {"mpp_voltage_v": 0.582, "open_circuit_voltage_v": 0.687, "mpp_current_a": 5.93}
LOSS_PER_K = 0.003
BATTERY_V = (18.0, 25.2)


def strings(series=30, conversion="any", **changes):
    mppt = {"minimum_voltage_v": 8.0, "maximum_voltage_v": 40.0, "maximum_current_a": 7.0}
    return Strings.model_validate(
        {
            "cells_in_series": series,
            "coldest_c": -20.0,
            "hottest_c": 75.0,
            "mppt": mppt | {"conversion": conversion},
        }
        | C60
        | changes
    )


def allowed(series, conversion):
    """Whether an MPPT takes so many cells, by the voltages of the string itself."""
    hot_v = series * 0.582 * (1.0 - 0.003 * 50.0)
    cold_v = series * 0.582 * (1.0 + 0.003 * 45.0)
    open_v = series * 0.687 * (1.0 + 0.003 * 45.0)
    inside = hot_v >= 8.0 and open_v <= 40.0
    if conversion == "step_up":
        return inside and cold_v <= BATTERY_V[0]
    if conversion == "step_down":
        return inside and hot_v >= BATTERY_V[1]
    return inside


@pytest.mark.parametrize("conversion", ["any", "step_up", "step_down"])
def test_window_is_that_of_every_number_by_itself(conversion):
    window = strings(conversion=conversion).window(LOSS_PER_K, BATTERY_V)
    numbers = range(1, 100)
    inside = [n for n in numbers if window.least <= n <= window.most]
    assert inside == [n for n in numbers if allowed(n, conversion)]
    assert [
        n for n in numbers if strings(n, conversion).problem(n, LOSS_PER_K, BATTERY_V) is None
    ] == inside


def test_trouble_names_key_and_what_is_allowed():
    assert strings(30).problem(60, LOSS_PER_K, None) is None
    window = "the MPPT takes 8 to 40 V, the modules have -20 to 75 °C"
    current, two = "the MPPT takes 7 A, a string gives 5.93 A", strings(30, strings_per_mppt=2)
    for found, key, message in (
        (strings(31), "cells_in_series", "must divide the 60 cells into whole strings (got 31)"),
        (strings(60), "cells_in_series", f"must be from 17 to 51: {window} (got 60)"),
        (two, "strings_per_mppt", f"must be at most 1: {current} (got 2)"),
        (strings(mpp_current_a=7.1), "mppt", "takes 7 A, less than the 7.1 A of a string"),
    ):
        assert found.problem(60, LOSS_PER_K, None) == (key, message)
    for key in C60:
        with pytest.raises(ValueError, match="required key is missing"):
            strings(**{key: None})


def test_a_coefficient_of_the_voltage_takes_precedence():
    colder = strings(voltage_coefficient_per_k=0.002)
    assert colder.voltage_v(0.582, 75.0, LOSS_PER_K) == pytest.approx(0.582 * 0.9)
    assert strings().voltage_v(0.582, 75.0, LOSS_PER_K) == pytest.approx(0.582 * 0.85)


@pytest.mark.parametrize(("cells", "series"), [(44, 44), (88, 44), (90, 45), (52, 26), (53, None)])
def test_fewest_strings_divide_the_cells(cells, series):
    series_strings = strings().for_cells(cells, LOSS_PER_K, None)
    assert (None if series_strings is None else series_strings.cells_in_series) == series


@pytest.mark.parametrize("key", ["coldest_c", "hottest_c"])
@pytest.mark.parametrize("value", [-300.0, -100.5, 101.0, float("nan")])
def test_temperatures_that_no_module_has_are_refused(key, value):
    with pytest.raises(ValidationError, match=key):
        strings(**{key: value})
    assert strings(coldest_c=-100.0, hottest_c=100.0).coldest_c == -100.0


@pytest.mark.parametrize("conversion", ["any", "step_up", "step_down"])
def test_cells_without_a_voltage_fit_no_mppt(conversion):
    hot = {"coldest_c": 80.0, "hottest_c": 90.0, "voltage_coefficient_per_k": 0.05}
    trouble = strings(30, conversion, **hot).problem(90, LOSS_PER_K, BATTERY_V)
    key, words = trouble
    assert key == "cells_in_series"
    assert words.startswith("no number of cells will do: the MPPT takes ")


def test_strings_may_be_of_unequal_length():
    lengths = (30, 30, 24)
    assert strings(lengths).problem(84, LOSS_PER_K, None) is None
    assert strings(lengths).mppts(84) == 3
    assert strings(22).mppts(88) == 4
    assert strings(22, strings_per_mppt=3).mppts(88) == 2
    for wrong, changes, message in (
        ((30, 30), {}, "must be the 84 cells in all"),
        ((30, 44, 10), {}, "(got 10)"),
        ((30, 24, 30), {"strings_per_mppt": 2}, "must be equal in each 2 strings"),
    ):
        problem = strings(wrong, **changes).problem(84, LOSS_PER_K, None)
        assert message in problem[1]
