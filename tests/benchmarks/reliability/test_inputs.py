"""The judge of changed inputs sees what it should, and its cases can be repeated."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from benchmarks.reliability.inputs import files, mutations
from benchmarks.reliability.inputs.cases import Case, rng_of
from benchmarks.reliability.inputs.judge import Outcome, mistake
from benchmarks.reliability.inputs.process import run_case


@pytest.mark.parametrize(
    ("outcome", "expected"),
    [
        (Outcome(0, '{"excess_time_h": NaN}', ""), "no strict JSON"),
        (Outcome(0, '{"a": 1', ""), "no strict JSON"),
        (Outcome(3, "", "words"), "exit code 3"),
        (Outcome(2, "", ""), "without a word"),
        (Outcome(2, "", "a name: \x1b[31m"), "control character"),
        (Outcome(2, "", "x" * 20_000), "message of 20000"),
        (Outcome(0, "{}", "RuntimeWarning: overflow"), "warning of a library"),
        (Outcome(1, "", "Traceback (most recent call last)"), "traceback printed"),
    ],
)
def test_what_must_not_be_is_seen(tmp_path: Path, outcome: Outcome, expected: str) -> None:
    found = mistake(Case(("analyse",), json=True), outcome, (), tmp_path)
    assert found is not None
    assert expected in found


def test_results_that_are_no_numbers_are_seen_and_names_are_not(tmp_path: Path) -> None:
    case = Case(("analyse",))
    assert mistake(case, Outcome(0, "excess time     nan h", ""), (), tmp_path) is not None
    assert mistake(case, Outcome(0, "nan.yaml on infinity-1: 2 h", ""), (), tmp_path) is None


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("out.csv", b"a,b\n1\n", "rows of different lengths"),
        ("out.csv", b"a\n=cmd()\n", "formula"),
        ("out.csv", b"a\ninf\n", "inf as a number"),
        ("out.svg", b"<svg>", "ends amid"),
        (".x.tmp", b"", "leaves .x.tmp behind"),
    ],
)
def test_files_that_are_not_whole_are_seen(
    tmp_path: Path, name: str, content: bytes, expected: str
) -> None:
    (tmp_path / name).write_bytes(content)
    case = Case(("analyse",), outputs=("out.csv", "out.svg"))
    found = mistake(case, Outcome(0, "", ""), (), tmp_path)
    assert found is not None
    assert expected in found
    refused = mistake(case, Outcome(2, "", "no"), (), tmp_path)
    assert refused is not None


def test_a_case_is_the_same_every_time() -> None:
    for maker in (files.aircraft_file, files.override, files.polar_table, files.folder):
        assert maker(rng_of(1, "a", 7)) == maker(rng_of(1, "a", 7))
        assert maker(rng_of(1, "a", 7)) != maker(rng_of(1, "a", 8))


def test_a_valid_file_stays_valid_only_where_nothing_is_changed(tmp_path: Path) -> None:
    assert run_case(0, Case(("validate", "a.yaml"), {"a.yaml": b"name: ["})).wrong is None
    assert mutations.bytes_changed(b"x" * 100, random.Random(1)) != b"x" * 100
