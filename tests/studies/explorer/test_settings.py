"""Whatever a page sends is either computed from or refused in words that JSON can carry."""

import json
import math

from hypothesis import given, settings
from hypothesis import strategies as st

from studies.explorer.fields import DAY, LATITUDE, Choice, Field, Option
from studies.explorer.settings import RefusedError, read_settings

FIELDS = {
    LATITUDE: Field(LATITUDE, "place", "latitude", "deg", 47.0, -90.0, 90.0, (-70.0, 70.0), 0.1),
    DAY: Field(DAY, "place", "day", "", 196.0, 1.0, 365.0, (1.0, 365.0), 1.0),
    "a": Field("a", "design", "a", "m", 2.0, 1.0, 3.0, (1.0, 3.0), 0.1, fixed="measured"),
    "model": Choice("model", "model", "CAM", (Option("CAM", "CAM"), Option("FM", "FM", "no"))),
    "correction": Choice("correction", "correction", "none", (Option("none", "none"),)),
}
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.just(10**400),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)
KEYS = st.sampled_from([*FIELDS, "__proto__", ""]) | st.text()


@given(ANYTHING | st.dictionaries(KEYS, ANYTHING, max_size=5))
@settings(max_examples=100, deadline=None, derandomize=True)
def test_settings_are_within_their_ranges_or_refused(data):
    try:
        read = read_settings(data, FIELDS)
    except RefusedError as error:
        told = [one._asdict() for one in error.refusals]
        assert told
        for one in told:
            assert one["message"]
            assert len(str(one["value"])) <= 60
            assert len(one["field"]) <= 60
        json.dumps([str(error), told], allow_nan=False).encode()
    else:
        assert all(map(math.isfinite, read.values.values()))
        assert -90.0 <= read.values[LATITUDE] <= 90.0
        assert 1 <= read.values[DAY] <= 365
        assert read.values["a"] == 2.0
        assert (read.solar.model, read.solar.correction) == ("CAM", "none")
