"""A design as a table of LaTeX, with the package booktabs."""

from __future__ import annotations

import re
from itertools import groupby

from sizing.results.tables import UNLIMITED
from studies.exchange.design_sheet import DesignSheet, Entry

__all__ = ["escaped", "latex_table"]

_ESCAPES = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#",
    "%": r"\%", "_": r"\_", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "°": r"$^\circ$", "²": r"$^2$", "³": r"$^3$", "−": r"$-$", "·": r"$\cdot$", "×": r"$\times$",
}  # fmt: skip


def latex_table(sheet: DesignSheet) -> str:
    """Table of a design: quantity, symbol, value and unit, a rule between its groups.

    Returns a ``table`` environment with caption and label, which needs ``booktabs``.
    """
    lines = [
        r"% \usepackage{booktabs}",
        r"\begin{table}",
        r"  \centering",
        rf"  \caption{{{escaped(sheet.title)}. {escaped(' '.join(sheet.notes))}}}",
        rf"  \label{{tab:{_label(sheet.title)}}}",
        r"  \begin{tabular}{llrl}",
        r"    \toprule",
        r"    Quantity & Symbol & Value & Unit \\",
    ]
    for _, some in groupby(sheet.quantities, key=lambda quantity: quantity.group):
        lines.append(r"    \midrule")
        lines += [f"    {_row(quantity)}" for quantity in some]
    lines += [r"    \bottomrule", r"  \end{tabular}", r"\end{table}"]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Text whose characters mean nothing to LaTeX."""
    return "".join(_ESCAPES.get(character, character) for character in text)


def _row(quantity: Entry) -> str:
    symbol = f"${quantity.symbol}$" if quantity.symbol else ""
    value = quantity.text()
    shown = value if value == UNLIMITED or isinstance(quantity.value, str) else f"${_power(value)}$"
    return f"{escaped(quantity.label)} & {symbol} & {shown} & {_unit(quantity.unit)} \\\\"


def _power(number: str) -> str:
    """Number with its exponent as a power of ten."""
    return re.sub(r"e([+-])0*(\d+)", lambda m: rf"\times 10^{{{m[1].strip('+')}{m[2]}}}", number)


def _unit(unit: str) -> str:
    """Unit in upright letters, exponents raised."""
    if unit == "1":
        return ""
    raised = re.sub(r"([A-Za-z])([23])", r"\1^\2", unit)
    return rf"$\mathrm{{{raised}}}$"


def _label(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "design"
