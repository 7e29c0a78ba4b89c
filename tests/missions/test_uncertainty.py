import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from missions.files.errors import InputError
from missions.library import load_mission
from missions.uncertainty import Data, LogNormal, Normal, Triangular, Uniform

UNIFORM = {"distribution": "uniform"}
SHARES = np.array([0.001, 0.1, 0.37, 0.5, 0.9, 0.999])


@pytest.mark.parametrize(
    ("distribution", "oracle"),
    [
        (Normal(sigma=2.0), stats.norm(10.0, 2.0)),
        (Normal(relative_sigma=0.3), stats.norm(10.0, 3.0)),
        (
            LogNormal(distribution="lognormal", relative_sigma=0.2),
            stats.lognorm(np.log(1.2), 0, 10.0),
        ),
        (Uniform(distribution="uniform", low=4.0, high=9.0), stats.uniform(4.0, 5.0)),
        (
            Triangular(distribution="triangular", low=4.0, high=14.0, mode=6.0),
            stats.triang(0.2, 4.0, 10.0),
        ),
        (Triangular(distribution="triangular", low=4.0, high=14.0), stats.triang(0.6, 4.0, 10.0)),
    ],
)
def test_quantiles_are_those_of_scipy(distribution, oracle):
    assert distribution.values(SHARES, 10.0) == pytest.approx(oracle.ppf(SHARES), rel=1e-12)


@given(st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=30))
def test_data_stay_within_their_values_and_rise(data):
    quantiles = Data(distribution="data", data=tuple(data)).values(np.linspace(0.0, 1.0, 50), 0.0)
    assert quantiles[0] == min(data)
    assert quantiles[-1] == max(data)
    assert np.all(np.diff(quantiles) >= 0.0)


BOTH, WIND = ["clearness", "wind_m_per_s"], {"coefficient": 0.5}
TWICE = [WIND | {"between": BOTH}, WIND | {"between": BOTH[::-1]}]


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"inputs": {"clearness": {"sigma": 0.1, "relative_sigma": 0.1}}}, "give this or sigma"),
        ({"inputs": {"clearness": {}}}, "required key is missing .or rel"),
        ({"inputs": {"clearness": {"distribution": "cauchy"}}}, "must be one of 'normal', 'logn"),
        ({"inputs": {"clearness": UNIFORM | {"low": 2, "high": 1}}}, "high: must be above low 2"),
        ({"inputs": {"clearness": {"distribution": "data", "data": [1]}}}, "at least 3 items"),
        ({"inputs": {"clearness": {"relative_sigma": -1}}}, "must be greater than 0"),
        ({"correlations": [WIND | {"between": ["clearness"] * 2}]}, "needs two different inputs"),
        ({"correlations": TWICE}, "is the second correlation of wind_m_per_s and clearness"),
    ],
)
def test_spreads_and_correlations_are_checked(section, message):
    with pytest.raises(InputError, match=message):
        load_mission("rafz-july", {"uncertainty": section})
