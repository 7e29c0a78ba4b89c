"""Edge of perpetual flight between the cells of a map."""

import numpy as np
import pytest

from studies.maps.plots import _continued


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_edge_lies_where_the_side_that_tends_to_zero_ends(sign):
    """On one side the excess time is linear to zero at 3.3; on the other it jumps by an hour."""
    rows = np.arange(8.0)[:, np.newaxis] + np.zeros((1, 3))
    excess_h = sign * np.where(rows < 3.3, rows - 3.3, 1.0 + 0.01 * rows)
    continued = _continued(excess_h)
    column = continued[:, 1]
    after = int(np.argmax(sign * column > 0.0))
    share = column[after - 1] / (column[after - 1] - column[after])
    assert after - 1 + share == pytest.approx(3.3)
    unchanged = np.delete(np.arange(8), after)
    np.testing.assert_array_equal(continued[unchanged], excess_h[unchanged])


def test_maps_without_an_edge_stay_as_they_are():
    excess_h = np.full((4, 5), 2.0)
    np.testing.assert_array_equal(_continued(excess_h), excess_h)
