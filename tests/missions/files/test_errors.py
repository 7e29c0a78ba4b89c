"""Tests of the problems that a user sees."""

from __future__ import annotations

import pickle

from missions.files.errors import InputError, Problem


def test_input_error_keeps_its_problems_through_pickling() -> None:
    error = InputError([Problem("b", 2, 1, "k", "m"), Problem("b", 1, None, "", "n")])
    assert str(error) == "b:1: n\nb:2:1: k: m"
    copied = pickle.loads(pickle.dumps(error))
    assert copied.problems == error.problems
    assert isinstance(error, ValueError)
