"""Values that no file of missions may have, and the words in which they are refused."""

from pathlib import Path

import pytest
import yaml
from refusals import refusals

from missions.files.errors import InputError
from missions.library import load_mission


@pytest.mark.parametrize(
    ("name", "changes", "message"), refusals(Path(__file__).with_name("refusals.txt"))
)
def test_values_that_cannot_be_are_refused_in_these_words(name, changes, message):
    with pytest.raises(InputError) as refused:
        load_mission(name, yaml.safe_load(changes))
    problems = refused.value.problems
    assert " | ".join(f"{one.key}: {one.message}" for one in problems) == message
