"""The page on reliability is that of the kept records, and every test that it names exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from documented import DOCS, ROOT

from benchmarks.reliability import __main__ as command
from benchmarks.reliability.page import Defect, defects, markdown
from benchmarks.reliability.record import Record, Row, kept, merged, of_cases

RECORD = Record("faults", "python -m x", 7, 3.0, (Row("map", "SIGKILL", 3, 2, ("seed 7",)),))
LISTED = [*defects("faults"), *defects("inputs")]


def test_the_page_is_that_of_the_records(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    assert CliRunner().invoke(command.main, ["--markdown", str(page)]).exit_code == 0
    assert page.read_text("utf-8") == (DOCS / "reliability.md").read_text("utf-8"), (
        "python -m benchmarks.reliability --markdown docs/reliability.md"
    )


@pytest.mark.parametrize("defect", LISTED, ids=lambda one: one.test.rpartition("::")[2])
def test_the_test_that_guards_a_defect_exists(defect: Defect) -> None:
    path, _, name = defect.test.partition("::")
    text = (ROOT / path).read_text(encoding="utf-8")
    assert re.search(rf"^(async )?def {re.escape(name)}\(", text, re.M), name


def test_what_did_not_hold_is_told() -> None:
    page = markdown({"faults": RECORD})
    assert "2 of 3 cases held" in page
    assert "- seed 7" in page


def test_records_are_read_as_they_were_kept(tmp_path: Path) -> None:
    RECORD.keep(tmp_path)
    assert kept(tmp_path) == {"faults": RECORD}


def test_newer_rows_take_the_place_of_older_ones() -> None:
    again, other = Row("map", "SIGKILL", 5, 5), Row("map", "Ctrl-C", 1, 1)
    newer = Record("faults", "python -m x", 8, 2.0, (again, other))
    assert merged(RECORD, newer).rows == (again, other)
    assert merged(newer, RECORD).rows == (RECORD.rows[0], other)
    assert merged(None, RECORD) == RECORD


def test_cases_are_counted() -> None:
    row = of_cases("map", "SIGKILL", [None, "traceback", None])
    assert (row.cases, row.held, row.broken) == (3, 2, ("traceback",))


def test_a_case_that_does_not_hold_fails_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = list(RECORD.rows)
    monkeypatch.setattr("benchmarks.reliability.faults.attacks", lambda *_: iter(rows))
    result = CliRunner().invoke(command.main, ["faults"])
    assert result.exit_code == 1
    assert "2 of 3 cases held" in result.output
    rows[:] = [of_cases("map", "SIGKILL", [None])]
    assert CliRunner().invoke(command.main, ["faults"]).exit_code == 0
