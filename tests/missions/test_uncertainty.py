import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from missions.uncertainty import Data, LogNormal, Normal, Triangular, Uniform

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
