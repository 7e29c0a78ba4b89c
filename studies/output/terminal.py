"""Results on the terminal: what describes itself is shown, in one place."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from sizing.results.tables import Result, Summary, Table


def console() -> Console:
    """Console of standard output; names from files are text, never markup."""
    from rich.console import Console

    return Console(highlight=False, markup=False, emoji=False)


def show(shown: Result | Summary | Table) -> None:
    """Print a result, a summary or a table to standard output, as wide as the terminal is.

    Parameters
    ----------
    shown : Result, Summary or Table
    """
    from sizing.results.tables import Result, Summary, Table

    summary = shown.summary() if isinstance(shown, Result) else shown
    summary = Summary((summary,)) if isinstance(summary, Table) else summary
    console().print(*summary.renderables(), sep="\n")
