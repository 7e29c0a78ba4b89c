"""Docstrings for readers: whole ones for what users call and for formulas, a sentence elsewhere."""

import ast
import re
from pathlib import Path

import pytest

import studies

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("solar", "missions", "sizing", "studies")
# Formulas of the physics, whose shapes, units and sources matter to whoever checks them.
FORMULAS = (
    "solar",
    "missions/air.py",
    "missions/flight_path.py",
    "missions/loiter_power.py",
    "sizing/aerodynamics",
    "sizing/battery",
    *(f"sizing/day/{name}.py" for name in ("balance", "battery", "cycle", "flight", "march")),
    "sizing/propulsion",
    "sizing/structures",
)
SECTION = re.compile(r"^(Parameters|Returns|Raises|Yields|Attributes)\n-{4,}$", re.M)

Function = ast.FunctionDef | ast.AsyncFunctionDef
Definition = Function | ast.ClassDef


def offered_names():
    """Names that the packages offer, as ``dir()`` shows them."""
    trees = (ast.parse((ROOT / p / "__init__.pyi").read_text(encoding="utf-8")) for p in PACKAGES)
    imports = (n for tree in trees for n in ast.walk(tree) if isinstance(n, ast.ImportFrom))
    return {alias.asname or alias.name for node in imports for alias in node.names}


def definitions(body, prefix):
    """Functions, classes and methods, with their dotted names."""
    for node in body:
        if isinstance(node, Definition):
            yield f"{prefix}.{node.name}", node
            if isinstance(node, ast.ClassDef):
                yield from definitions(node.body, f"{prefix}.{node.name}")


def all_definitions():
    """Every definition: its file, the dotted name and the node."""
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            relative = path.relative_to(ROOT)
            tree = ast.parse(path.read_text(encoding="utf-8"))
            for name, node in definitions(tree.body, ".".join(relative.with_suffix("").parts)):
                yield relative, name, node


def is_formula(path):
    return path.as_posix().startswith(FORMULAS)


def is_offered(path, name, offered):
    """Whether a name, or the class that it belongs to, is one that users get."""
    inner = name.removeprefix(".".join(path.with_suffix("").parts) + ".")
    return inner.partition(".")[0] in offered


def argument_count(function):
    given = function.args
    names = [a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    names += [a.arg for a in (given.vararg, given.kwarg) if a is not None]
    return len([name for name in names if name not in ("self", "cls")])


def missing_sections(function):
    text = ast.get_docstring(function) or ""
    returns = function.returns is not None and ast.unparse(function.returns) not in (
        "None",
        "NoReturn",
    )
    decorators = [ast.unparse(decorator) for decorator in function.decorator_list]
    # What figures return is said by their style.
    returns = returns and not {"styled", "drawing.styled"}.intersection(decorators)
    wanted = {"Parameters": "Parameters"} | ({"Returns": "Returns|Yields"} if returns else {})
    return [
        name
        for name, titles in wanted.items()
        if not re.search(rf"^({titles})\n-{{4,}}$", text, re.M)
    ]


def test_figures_say_how_they_look_and_what_they_return():
    drawn = [name for name in offered_names() if name.startswith("plot_")]
    for text in (getattr(studies, name).__doc__ for name in drawn):
        assert text.count("figure : FigureOptions or Figure\n    How the figure looks") == 1
        assert SECTION.findall(text)[:2] == ["Parameters", "Returns"]


def is_private(name):
    return any(part.startswith("_") for part in name.split("."))


def is_exempt(function):
    """Tell whether the terminal's help (click) or another definition (overload) documents it."""
    decorators = [ast.unparse(decorator) for decorator in function.decorator_list]
    return any(
        re.search(r"\b(command|group|option|argument)\(|\boverload\b", text) for text in decorators
    )


@pytest.mark.long
def test_what_users_call_lists_parameters_and_returns():
    offered = offered_names()
    incomplete = {
        name: missing
        for path, name, node in all_definitions()
        if isinstance(node, Function) and is_offered(path, name, offered)
        if not is_private(name) and not is_exempt(node) and argument_count(node) >= 2
        if (missing := missing_sections(node))
    }
    assert not incomplete, f"sections of the docstrings are missing: {incomplete}"


@pytest.mark.long
def test_inner_names_have_a_sentence_and_no_sections():
    offered = offered_names()
    wordy = [
        name
        for path, name, node in all_definitions()
        if not is_formula(path) and not is_offered(path, name, offered)
        if SECTION.search(ast.get_docstring(node) or "")
    ]
    assert not wordy, f"inner names need a sentence, not sections: {wordy}"
