"""Published numbers and the report's means as results that print themselves."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import Run

from studies.validation import published as study
from studies.validation.report_reproduction import Reproduction, reference, reproduce


@pytest.fixture(scope="module")
def result() -> study.Published:
    return study.published()


def test_every_number_is_met_but_the_known_misses(result: study.Published) -> None:
    missed = [n for n in result.numbers if not n.met]
    # They are discussed in the documentation. One that is met one day is a known miss no longer.
    assert missed == [n for n in result.numbers if n.known_miss]
    assert [n.quantity for n in missed] == [
        "state of charge after 24 h",
        "minimum state of charge",
        "time flown",
    ]
    assert result.met
    count = len(result.numbers)
    assert result.headline().startswith(
        f"{count - 3} of {count} published numbers are met, 3 known"
    )


def test_the_command_prints_and_writes_them(
    result: study.Published, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "published", lambda progress: result)
    outcome = run("published", "--json", "--markdown", "table.md")
    assert (outcome.code, outcome.err) == (0, "")
    rows = outcome.json()
    assert len(rows) >= 10
    assert all(row["met"] or row["known_miss"] for row in rows)
    number = {"quantity", "source", "unit", "published", "computed", "allowed", "known_miss"}
    assert set(rows[0]) == number | {"difference", "met"}
    table = (tmp_path / "table.md").read_text(encoding="utf-8").splitlines()
    assert len(table) == len(rows) + 2
    assert all(line.startswith("| ") for line in table[2:])


def test_text_has_a_table_for_each_source_and_fits_the_terminal(result: study.Published) -> None:
    text = str(result)
    for number in result.numbers:
        assert number.source in text
    assert max(map(len, text.splitlines())) <= 80
    assert len(result.to_frame()) == len(result.to_dict()) == len(result.numbers)


def test_a_missed_number_counts() -> None:
    missed = study.Number("mass", "a book", "kg", 1.0, 1.2, 0.1)
    assert study.Published((missed,)).headline() == "0 of 1 published numbers are met"
    assert not study.Published((missed,)).met
    known = study.Number("mass", "a book", "kg", 1.0, 1.2, 0.1, known_miss=True)
    assert study.Published((known,)).met
    assert "no, known" in str(study.Published((known,)))


def test_largest_difference_from_the_report_is_the_headline() -> None:
    aircraft, mission = reference()
    models = {"CDM": 117.35, "CAM": 104.89, "VM": 97.65, "FM": 97.87 * 1.02}
    result = Reproduction(aircraft, mission, models, (35.3, 140.5 * 0.95, 204.7))  # type: ignore[arg-type]  # names of models
    assert "within 5.0 % of the report's" in result.headline()
    assert result.to_dict()["windows"][0]["published_w"] == 35.3


def test_assumptions_are_varied_on_request() -> None:
    result = reproduce(*reference())
    assert result.varied == ()
    assert len(result.tables()) == 1
