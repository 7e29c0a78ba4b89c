"""Values that no file of aircraft may have, and the words in which they are refused."""

from pathlib import Path

import pytest
from refusals import refusal_of, refusals

from sizing.library import load_aircraft


@pytest.mark.parametrize(
    ("name", "changes", "message"), refusals(Path(__file__).with_name("refusals.txt"))
)
def test_values_that_cannot_be_are_refused_in_these_words(name, changes, message):
    assert refusal_of(load_aircraft, name, changes) == message
