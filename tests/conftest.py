"""Settings of all tests, and the command ``solar-uav`` as a test runs it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from command_line import Outcome, Run
from hypothesis import settings

# The same examples every time, so that a change is judged and not the dice; without a deadline,
# because a busy machine is no fault. As they are the same, fifty cover the branches that a hundred
# do. HYPOTHESIS_PROFILE=explore tries other examples, and more.
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=50)
settings.register_profile("explore", max_examples=500, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    """Run the command in an empty folder; nothing but an exit may leave it."""
    from studies.cli import __main__ as cli

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def call(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["solar-uav", *arguments])
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            cli.main()
        out, err = capfd.readouterr()
        code = ended.value.code
        assert code is None or isinstance(code, int)
        return Outcome(code or 0, out, err)

    return call
