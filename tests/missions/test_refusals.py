"""Values that no file of missions may have, and the words in which they are refused."""

from pathlib import Path

import pytest
from refusals import refusal_of, refusals

from missions.library import load_mission


@pytest.mark.parametrize(
    ("name", "changes", "message"), refusals(Path(__file__).with_name("refusals.txt"))
)
def test_values_that_cannot_be_are_refused_in_these_words(name, changes, message):
    assert refusal_of(load_mission, name, changes) == message
