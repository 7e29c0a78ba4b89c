"""Changes of one token: which there are, and that tests which would find them are run."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest
from documented import ROOT
from source_tree import make_benchmarks_importable

make_benchmarks_importable()
from benchmarks import mutant_rows  # noqa: E402 - only now they can be found
from benchmarks.mutant_rows import Row, harmless, kept, table  # noqa: E402
from benchmarks.mutations import changed_source, mutations  # noqa: E402


def changed(source: str) -> list[str]:
    return [changed_source(source, change) for change in mutations(source)]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = (a) * (b)", ["x = (a) / (b)"]),
        ("x = é ** -b", ["x = é * -b", "x = é ** b"]),
        ("x = a < b == c", ["x = a <= b == c", "x = a > b == c", "x = a < b != c"]),
        ("x = a is not b", ["x = a is b"]),
        (
            "x = a and b or not c",
            ["x = a or b or not c", "x = a and b and not c", "x = a and b or  c"],
        ),
        ("x += 1", ["x -= 1", "x += 0", "x += 2"]),
    ],
)
def test_every_token_has_its_changes(source: str, expected: list[str]) -> None:
    assert sorted(changed(source)) == sorted(expected)


def test_numbers_truth_values_and_functions_are_changed() -> None:
    assert set(changed("x = np.minimum(0.5, f(0.0), True)")) == {
        "x = np.maximum(0.5, f(0.0), True)",
        "x = np.minimum(0.25, f(0.0), True)",
        "x = np.minimum(1.0, f(0.0), True)",
        "x = np.minimum(0.5, f(1.0), True)",
        "x = np.minimum(0.5, f(0.0), False)",
    }


def test_what_is_not_run_is_left_alone() -> None:
    source = dedent(
        '''
        """Docstring of 2 * 3."""
        if TYPE_CHECKING:
            limit = 3
        Number = int | float

        @dataclass(frozen=True)
        class Thing:
            x: Annotated[float, 1.0]

            def f(self, y: Literal[1]) -> Literal[2]:
                """Another 1."""
                return f"{y + 1}"
        '''
    )
    assert mutations(source) == []


def test_statements_know_their_lines_and_whether_they_run_at_import() -> None:
    source = dedent(
        """\
        SIZE = 1

        def f(x=2):
            if x > (
                y
            ):
                return -x
        """
    )
    found = {(one.lines, one.at_import) for one in mutations(source)}
    assert found == {
        (range(1, 2), True),
        (range(3, 4), True),
        (range(4, 7), False),
        (range(7, 8), False),
    }


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["solar/shading.py", "missions/mission.py", "sizing/mass_budget.py"]
)
def test_every_change_of_a_module_can_be_parsed_and_is_one(name: str) -> None:
    source = (ROOT / name).read_text(encoding="utf-8")
    own = ast.dump(ast.parse(source))
    texts = changed(source)
    assert len(set(texts)) == len(texts) > 100
    assert all(ast.dump(ast.parse(text)) != own for text in texts[::7])


# ---- the table


def row(found: str | None, change: str = "`1` to `2`", module: str = "sizing/energy/a.py") -> Row:
    return Row(module, 3, hash(change), change, "x = 1", change, found, tests=1)


def test_rows_are_counted_by_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    same = {("sizing/energy/a.py", "x = 1", "c"): "no effect"}
    monkeypatch.setattr(mutant_rows, "harmless", lambda: same)
    rows = tmp_path / "rows"
    for one in (row("t", "a"), row(None, "b"), row(None, "c"), row(None, "d"), row("t", "d")):
        one.keep(rows)
    row("hung", module="solar/b.py").keep(rows)
    assert [line for line in table(kept(rows).values()) if line][2:] == [
        "| sizing.energy | 4 | 2 | 1 | 1 | 1 | 66.7 % |",
        "| solar | 1 | 1 | 0 | 0 | 0 | 100.0 % |",
        "| all | 5 | 3 | 1 | 1 | 1 | 75.0 % |",
        "These survived:",
        "- sizing/energy/a.py:3: b in `x = 1`",
    ]


def test_harmless_changes_are_those_of_lines_that_exist() -> None:
    for (module, code, change), reason in harmless().items():
        lines = map(str.strip, (ROOT / module).read_text(encoding="utf-8").splitlines())
        assert code in lines, (module, code)
        assert reason, change


# ---- a small project

MODULE = '''\
"""Half and twice of a number."""

FACTOR = 2.0
_known = {}


def half(x):
    while x > 8.0:
        x -= 1.0
    return x / FACTOR


def twice(x):
    if x not in _known:
        _known[x] = x * 2.0
    return _known[x]


def never(x):
    return x + 1
'''
TESTS = """\
from solar.thing import half, twice


def test_half():
    assert half(9.0) == 4.0


def test_twice_gives_a_number():
    assert isinstance(twice(3.0), float)


def test_twice():
    assert twice(3.0) == 6.0
"""


RUN = """
import sys
from pathlib import Path
from benchmarks import mutants

mutants._PROJECT = Path(sys.argv[1])
mutants._AT_LEAST_S = 20.0
mutants.main(sys.argv[2:])
"""


@pytest.mark.slow
def test_changes_are_found_by_the_tests_that_execute_them(tmp_path: Path) -> None:
    pytest.importorskip("coverage")
    project, rows_file = tmp_path / "project", tmp_path / "rows"
    for name, text in {
        "solar/__init__.py": "",
        "solar/thing.py": MODULE,
        "tests/solar/test_thing.py": TESTS,
        "pyproject.toml": "[tool.pytest.ini_options]\naddopts = ['--import-mode=importlib']\n",
    }.items():
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_text(text, encoding="utf-8")
    arguments = ["--count", "100", "--work", str(tmp_path), "--rows", str(rows_file)]
    # A process of its own, which has not imported the real package.
    told = subprocess.run(
        [sys.executable, "-c", RUN, str(project), *arguments],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    found: dict[str, set[tuple[str | None, int]]] = {}
    for one in kept(rows_file).values():
        test = one.found and one.found.rpartition("::")[2]
        found.setdefault(one.code, set()).add((test, one.tests))
    # The constant has its effect in other lines; the first of two tests computes for both.
    assert found["FACTOR = 2.0"] == {("test_half", 3)}
    assert found["_known[x] = x * 2.0"] == {("test_twice", 3)}
    assert found["x -= 1.0"] >= {("hung", 1)}
    assert found["return x + 1"] == {(None, 0)}
    assert "`return x + 1`, which no test executes" in told
    assert (tmp_path / "tree/solar/thing.py").read_text(encoding="utf-8") == MODULE
