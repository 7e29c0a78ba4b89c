"""Latitudes as people write them."""

import pytest

from studies.cli.values import latitude_deg

NORTH = {"40.4N": 40.4, ".5 n": 0.5, " 47.6 ": 47.6}
SOUTH = {"48 S": -48.0, "48° S": -48.0, "33.9s": -33.9, "-33.9": -33.9, "90S": -90.0}


@pytest.mark.parametrize(("text", "degrees"), [*NORTH.items(), *SOUTH.items()])
def test_hemispheres(text, degrees):
    assert latitude_deg(text) == degrees


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("95N", r"must be from -90 to 90 \(got 95N\)"),
        ("nan", "must be from -90 to 90"),
        ("-48 S", "is not a number of degrees"),  # which of the two is meant
        ("48 W", "north is positive"),
        ("4_8", "is not a number of degrees"),
        ("", "is not a number of degrees"),
    ],
)
def test_other_texts_are_refused(text, message):
    with pytest.raises(ValueError, match=message):
        latitude_deg(text)
