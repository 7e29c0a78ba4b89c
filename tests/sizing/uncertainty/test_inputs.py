import numpy as np
import pytest
from scipy.stats import binomtest

from sizing.uncertainty.inputs import Proportion


def test_the_interval_is_wilsons():
    proportion = Proportion.of(np.arange(100) < 92)
    # Wilson (1927), by scipy's binomtest.
    interval = binomtest(92, 100).proportion_ci(method="wilson")
    assert (proportion.low, proportion.high) == pytest.approx((interval.low, interval.high))
    never = Proportion.of(np.zeros(50, bool))
    assert never.low == 0.0
    assert 0.0 < never.high < 0.1
    assert Proportion.of(np.ones(50, bool)).high == pytest.approx(1.0)
