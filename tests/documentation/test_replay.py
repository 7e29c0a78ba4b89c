"""The replay of the pages keeps what they leave out, and says what it cannot align."""

import runpy
from pathlib import Path
from typing import Any

import pytest
from documented import ROOT


@pytest.fixture(scope="module")
def replay() -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "docs" / "replay.py"))


@pytest.mark.parametrize(
    ("claimed", "printed", "renewed"),
    [
        ("mass 4.1 kg\nspan 3 m", "mass 5.12 kg\nspan 2 m\n", "mass 5.12 kg\nspan 2 m"),
        # What is left out stays so, at the beginning, in between and at the end.
        ("...\nb 2\n...\nd 4\n...", "a 1\nb 7\nc 3\nd 8\ne 5", "...\nb 7\n...\nd 8\n..."),
        ("a 1\n...\nc 3", "a 9\nb 2\nx 5\nc 8\n", "a 9\n...\nc 8"),
        # The first of two alike, then the one below it.
        ("...\nx 1\n...\nx 2\n...", "x 5\ny\nx 6\nz", "...\nx 5\n...\nx 6\n..."),
        (
            "...\na 1.5\n───\nb 2\n...",
            "h\na 10.25\n──────\nb 3\nc",
            "...\na 10.25\n──────\nb 3\n...",
        ),
        # No page claims what varies from run to run.
        ("a 1\n26 iterations, 22 ms", "a 2\n8 iterations, 25 ms", "a 2\n..."),
        ("a 1\n26 iterations\n...", "a 2\n8 iterations\nb", "a 2\n..."),
        ("...\na 1\nb 2\n...", "c 1\nd 2", None),
        ("a 1\n...\nc 3", "a 1\nb 2", None),
    ],
)
def test_claim_is_renewed(
    replay: dict[str, Any], claimed: str, printed: str, renewed: str | None
) -> None:
    assert replay["renewed"](claimed, printed) == renewed


def test_texts_of_a_comment_are_looked_for_without_their_numbers(replay: dict[str, Any]) -> None:
    printed = "│ span │ 4.15 m │\nbattery  2.79 kg"
    assert replay["likely"]("span 4.18 m", printed) == ["span │ 4.15 m"]
    assert replay["likely"]("battery 2.8 kg", printed) == ["battery 2.79 kg"]


def test_pages_are_written_from_the_last_claim_to_the_first(
    replay: dict[str, Any], tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    page.write_text("```text\n$ a\nx 1\n$ b\nx 1\n```\n\n```text\n$ c\nx 1\n```\n")
    replay["rewrite"](page, [(1, "x 1", "x 2"), (1, "x 1", "x 3\nx 4"), (8, "x 1", "x 5")])
    assert page.read_text() == ("```text\n$ a\nx 2\n$ b\nx 3\nx 4\n```\n\n```text\n$ c\nx 5\n```\n")
