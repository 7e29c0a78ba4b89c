"""Public functions of two or more arguments list their parameters and what they return."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("solar", "missions", "sizing", "studies")

Function = ast.FunctionDef | ast.AsyncFunctionDef


def public_modules() -> Iterator[Path]:
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            names = path.relative_to(ROOT).with_suffix("").parts
            if not any(name.startswith("_") and name != "__init__" for name in names):
                yield path


def public_functions(body: list[ast.stmt], prefix: str) -> Iterator[tuple[str, Function]]:
    """Functions and methods of public classes, with their dotted names."""
    for node in body:
        if not isinstance(node, Function | ast.ClassDef) or node.name.startswith("_"):
            continue
        name = f"{prefix}.{node.name}"
        if isinstance(node, ast.ClassDef):
            yield from public_functions(node.body, name)
        elif not is_exempt(node):
            yield name, node


def is_exempt(function: Function) -> bool:
    """Tell whether the terminal's help (click) or another definition (overload) documents it."""
    decorators = [ast.unparse(decorator) for decorator in function.decorator_list]
    return any(
        re.search(r"\b(command|group|option|argument)\(|\boverload\b", text) for text in decorators
    )


def argument_count(function: Function) -> int:
    given = function.args
    names = [a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    names += [a.arg for a in (given.vararg, given.kwarg) if a is not None]
    return len([name for name in names if name not in ("self", "cls")])


def missing_sections(function: Function) -> list[str]:
    text = ast.get_docstring(function) or ""
    returns = function.returns is not None and ast.unparse(function.returns) not in (
        "None",
        "NoReturn",
    )
    wanted = {"Parameters": "Parameters"} | ({"Returns": "Returns|Yields"} if returns else {})
    return [
        name
        for name, titles in wanted.items()
        if not re.search(rf"^({titles})\n-{{4,}}$", text, re.M)
    ]


def incomplete_functions() -> dict[str, list[str]]:
    """Sections that are missing, by the dotted name of the function."""
    found = {}
    for path in public_modules():
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for name, function in public_functions(tree.body, module):
            if argument_count(function) >= 2 and (missing := missing_sections(function)):
                found[name] = missing
    return found


def test_functions_of_two_or_more_arguments_are_documented() -> None:
    incomplete = incomplete_functions()
    assert not incomplete, f"sections of the docstrings are missing: {incomplete}"
