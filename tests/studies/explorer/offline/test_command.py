"""``solar-uav explore --static`` without a browser: the file, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from command_line import Run, files

AS2 = "atlantiksolar-as2"


@pytest.mark.long
def test_page_is_written_without_a_server(run: Run, tmp_path: Path) -> None:
    outcome = run("explore", AS2, "--set", "battery.mass_kg=3.1", "--static", "as2.html")
    assert (outcome.code, outcome.out, outcome.err) == (0, "written to as2.html\n", "")
    assert files(tmp_path) == {"as2.html"}
    page = (tmp_path / "as2.html").read_text(encoding="utf-8")
    # One file: nothing is loaded, from nowhere.
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert not re.search(r"\bimport\s*[({]", page.partition('<script type="module">')[2])
    assert "default-src 'none'" in page


def test_serving_and_writing_exclude_each_other(run: Run, tmp_path: Path) -> None:
    for option in (["--port", "8000"], ["--no-browser"]):
        outcome = run("explore", AS2, "--static", "as2.html", *option)
        assert (outcome.code, outcome.out) == (2, "")
        assert "--static serves nothing" in outcome.err
    outcome = run("explore", AS2, "--static", "no/folder.html")
    assert (outcome.code, outcome.out) == (1, "")
    assert "its folder does not exist" in outcome.err
    assert files(tmp_path) == set()
