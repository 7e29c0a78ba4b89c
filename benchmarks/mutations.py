"""Every change of one token that a module of Python allows, by its syntax tree.

An operator is exchanged for its opposite, a number is changed, a truth value or a comparison turned
round, a minus or a ``not`` left out, a function such as ``min`` exchanged for its counterpart.
Docstrings, annotations, decorators, f-strings and code for type checkers alone are left as they
are.
"""

from __future__ import annotations

import ast
import io
import tokenize
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

__all__ = ["Mutation", "changed_source", "mutations"]

_OPERATORS: dict[type[ast.AST], tuple[str, ...]] = {
    ast.Add: ("-",),
    ast.Sub: ("+",),
    ast.Mult: ("/",),
    ast.Div: ("*",),
    ast.FloorDiv: ("*",),
    ast.Mod: ("*",),
    ast.Pow: ("*",),
    ast.BitAnd: ("|",),
    ast.BitOr: ("&",),
    ast.Lt: ("<=", ">"),
    ast.LtE: ("<", ">="),
    ast.Gt: (">=", "<"),
    ast.GtE: (">", "<="),
    ast.Eq: ("!=",),
    ast.NotEq: ("==",),
    ast.Is: ("is not",),
    ast.IsNot: ("is",),
    ast.In: ("not in",),
    ast.NotIn: ("in",),
    ast.And: ("or",),
    ast.Or: ("and",),
}
_PAIRS = (
    ("min", "max"),
    ("minimum", "maximum"),
    ("argmin", "argmax"),
    ("fmin", "fmax"),
    ("any", "all"),
    ("floor", "ceil"),
    ("sin", "cos"),
    ("zeros", "ones"),
)
_NAMES = {a: b for pair in _PAIRS for a, b in (pair, pair[::-1])}


class Mutation(NamedTuple):
    """A change of one token.

    Attributes
    ----------
    line : int
        Line of the token, from 1.
    start, end : int
        Place of the token in the source, in bytes.
    new : str
        What stands there instead.
    lines : range
        Lines of the statement, without the statements inside it.
    at_import : bool
        Whether the statement runs when the module is imported.
    """

    line: int
    start: int
    end: int
    new: str
    lines: range
    at_import: bool


def mutations(source: str) -> list[Mutation]:
    """All changes of one token, in the order of the source.

    Parameters
    ----------
    source : str
        Of a module.

    Returns
    -------
    list of Mutation
    """
    changes = _Changes(source)
    changes.visit(ast.parse(source))
    return sorted(changes.found, key=lambda change: (change.start, change.new))


def changed_source(source: str, change: Mutation) -> str:
    """Source with the change made.

    Parameters
    ----------
    source : str
        Of the module.
    change : Mutation
        One of its changes.

    Returns
    -------
    str
    """
    text = source.encode()
    return (text[: change.start] + change.new.encode() + text[change.end :]).decode()


class _Changes(ast.NodeVisitor):
    """Collects the changes of a source in ``found``."""

    def __init__(self, source: str) -> None:
        self.found: list[Mutation] = []
        self._text = source.encode()
        self._line_starts = [0]
        for line in self._text.splitlines(keepends=True):
            self._line_starts.append(self._line_starts[-1] + len(line))
        # The tree knows operands, not where the operator between them stands.
        self._tokens = [
            (self._offset(token, token.start), self._offset(token, token.end))
            for token in tokenize.generate_tokens(io.StringIO(source).readline)
            if token.type in (tokenize.OP, tokenize.NAME) and token.string not in "()"
        ]
        self._lines = range(0)
        self._at_import = True

    def _offset(self, token: tokenize.TokenInfo, place: tuple[int, int]) -> int:
        """Place in bytes; a token of one line tells it in characters of that line."""
        line, column = place
        return self._line_starts[line - 1] + len(token.line[:column].encode())

    def _span(self, node: ast.expr) -> tuple[int, int]:
        """First and last place of an expression in bytes."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return (
            self._line_starts[node.lineno - 1] + node.col_offset,
            self._line_starts[node.end_lineno - 1] + node.end_col_offset,
        )

    # ---- what is passed over, and where a statement begins

    def visit(self, node: ast.AST) -> None:
        """Changes of a node and of what is inside it."""
        if not isinstance(node, ast.stmt):
            super().visit(node)
            return
        outer, self._lines = self._lines, _header(node)
        super().visit(node)
        self._lines = outer

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        """Defaults, which are computed at import, and the body, which is not."""
        self.visit(node.args)
        outer, self._at_import = self._at_import, False
        self._visit_all(node.body)
        self._at_import = outer

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        """Statements of the class, without its decorators."""
        self._visit_all(node.body)

    def visit_arg(self, node: ast.arg) -> None:
        """Nothing: a name and its annotation."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Nothing: Python 3.11 does not tell the places inside."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Value, without the annotation."""
        if node.value is not None:
            self.visit(node.value)

    def visit_If(self, node: ast.If) -> None:
        """All but what is for type checkers alone."""
        if ast.unparse(node.test) not in ("TYPE_CHECKING", "typing.TYPE_CHECKING"):
            self.generic_visit(node)

    def _visit_all(self, nodes: Sequence[ast.AST]) -> None:
        for node in nodes:
            self.visit(node)

    # ---- what is changed

    def visit_BinOp(self, node: ast.BinOp) -> None:
        """Exchange the operator; ``|`` of a module is a union of types."""
        if not (self._at_import and isinstance(node.op, ast.BitOr)):
            self._exchange(node.op, node.left, node.right)
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        """Exchange every comparison."""
        operands = [node.left, *node.comparators]
        for operator, (left, right) in zip(node.ops, pairwise(operands), strict=True):
            self._exchange(operator, left, right)
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        """Exchange ``and`` and ``or``."""
        for left, right in pairwise(node.values):
            self._exchange(node.op, left, right)
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        """Exchange the operator of an assignment."""
        self._exchange(node.op, node.target, node.value, suffix="=")
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        """Leave out a minus, ``not`` or ``~``."""
        if not isinstance(node.op, ast.UAdd):
            start = self._span(node)[0]
            length = 3 if isinstance(node.op, ast.Not) else 1
            self._add(start, start + length, "")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        """Change a number or a truth value."""
        value = node.value
        if isinstance(value, bool):
            self._add(*self._span(node), str(not value))
        elif isinstance(value, int):
            self._add(*self._span(node), str(value + 1), str(value - 1) if value else "-1")
        elif isinstance(value, float):
            self._add(
                *self._span(node), *(map(repr, (2.0 * value, 0.5 * value) if value else (1.0,)))
            )

    def visit_Name(self, node: ast.Name) -> None:
        """Exchange a function for its counterpart."""
        if node.id in _NAMES and isinstance(node.ctx, ast.Load):
            self._add(*self._span(node), _NAMES[node.id])

    def visit_Attribute(self, node: ast.Attribute) -> None:
        """Exchange a function of a module or a method for its counterpart."""
        if node.attr in _NAMES and isinstance(node.ctx, ast.Load):
            end = self._span(node)[1]
            self._add(end - len(node.attr), end, _NAMES[node.attr])
        self.generic_visit(node)

    def _exchange(
        self, operator: ast.AST, left: ast.expr, right: ast.expr, suffix: str = ""
    ) -> None:
        """Exchange the operator between two operands."""
        after, before = self._span(left)[1], self._span(right)[0]
        first = bisect_left(self._tokens, (after, 0))
        between = [place for place in self._tokens[first : first + 3] if place[1] <= before]
        new = _OPERATORS.get(type(operator), ())
        self._add(between[0][0], between[-1][1], *(text + suffix for text in new))

    def _add(self, start: int, end: int, *texts: str) -> None:
        line = bisect_right(self._line_starts, start)
        for new in texts:
            self.found.append(Mutation(line, start, end, new, self._lines, self._at_import))


def _header(statement: ast.stmt) -> range:
    """Lines of a statement up to the first statement inside it."""
    inner = [part.lineno for part in ast.walk(statement) if isinstance(part, ast.stmt)]
    inside = [line for line in inner if line > statement.lineno]
    last = min(inside) - 1 if inside else statement.end_lineno or statement.lineno
    return range(statement.lineno, last + 1)
