"""Settings of all tests, and the command ``solar-uav`` as a test runs it."""

import os
import sys
from unittest.mock import patch

# Two workers whose matrices take two threads each wait for each other on two cores: tests took four
# times the processor time. To be set before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from functools import wraps

import numpy as np
import pytest
from browser_pages import chromium, open_page, pytest_collection_modifyitems
from command_line import Outcome
from hypothesis import settings

# Fixtures and hooks that pytest finds by their name here.
__all__ = ["chromium", "open_page", "pytest_collection_modifyitems"]

# The same examples every time, so that a change is judged and not the dice; without a deadline,
# because a busy machine is no fault. As they are the same, fifty cover the branches that a hundred
# do. HYPOTHESIS_PROFILE=explore tries other examples, and more.
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=50)
settings.register_profile("explore", max_examples=500, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def computed_once(function):
    """Function that keeps its arrays by its arguments; they cannot be changed."""
    known = {}

    @wraps(function)
    def remembered(*arguments, **options):
        key = tuple(map(_key, arguments)), tuple((k, _key(v)) for k, v in options.items())
        if key not in known:
            known[key] = function(*arguments, **options)
            known[key].flags.writeable = False
        return known[key]

    return remembered


def _key(value):
    if isinstance(value, np.ndarray):
        return value.shape, str(value.dtype), value.tobytes()
    if isinstance(value, tuple):
        return tuple(map(_key, value))
    return type(value), value


@pytest.fixture(scope="session", autouse=True)
def _full_model_computed_once():
    """The Full Model's day on a path, 10 ms: comparisons and seasons ask for the same hundreds.

    Tests of the model itself call it where it is defined.
    """
    with pytest.MonkeyPatch.context() as context:
        from sizing.day import module_power

        once = computed_once(module_power.mean_power_on_path)
        context.setattr(module_power, "mean_power_on_path", once)
        yield


@pytest.fixture(scope="session", autouse=True)
def _coarse_images():
    """Figures are drawn with a fifth of their dots: nobody looks at those of tests."""
    with pytest.MonkeyPatch.context() as context:
        context.setattr("studies.output.figures.options.DOTS_PER_INCH", 30)
        yield


@pytest.fixture
def registries():
    """Skies and shading models that a test registers are forgotten after it."""
    from solar import clearsky, shading

    with patch.dict(clearsky.CLEAR_SKIES), patch.dict(shading.LOSS_MODELS):
        yield


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Run the command in an empty folder; nothing but an exit may leave it."""
    from studies.cli import __main__ as cli

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["solar-uav", *arguments])
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            cli.main()
        out, err = capfd.readouterr()
        code = ended.value.code
        assert code is None or isinstance(code, int)
        return Outcome(code or 0, out, err)

    return call
