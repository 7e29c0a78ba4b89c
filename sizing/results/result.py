"""What all results are: plain numbers, which the layer above renders and serialises."""

from __future__ import annotations

import math
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    import pandas as pd

    from solar.types import FloatArray


def data_frame(data: Any, columns: list[str] | None = None) -> pd.DataFrame:
    """Return a frame of pandas, whose import takes longer than most results themselves."""
    import pandas as pd

    return pd.DataFrame(data, columns=columns)


TABLES, SERIALISER = "studies.render.tables", "studies.serialise"


class Result:
    """A result: plain numbers, which the layer above renders and serialises.

    Results know of it no more than names of modules, by which it is imported when somebody looks at
    a result. ``renderer``: module with ``headline`` and ``blocks`` of the result; that of its class
    by default.
    """

    renderer: ClassVar[str] = ""

    def _render(self) -> Any:
        return import_module(self.renderer or type(self).__module__)

    def headline(self) -> str:
        """Return the result in one line."""
        return str(self._render().headline(self))

    def summary(self) -> Any:
        """Return the :class:`studies.Summary` of the result that fits a screen."""
        return self.at_level(1)

    def at_level(self, level: int) -> Any:
        """Return a :class:`studies.Summary` of the result: short at level 1, all of it at 2.

        A quantity is shown from its importance on.
        """
        return import_module(TABLES).Summary(tuple(self._render().blocks(self, level)))

    def to_dict(self) -> dict[str, Any]:
        """Return the whole result, JSON-ready; null where a number is unlimited or not defined."""
        record: dict[str, Any] = import_module(SERIALISER).serialise(self)
        return record

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.headline()}>"

    def __str__(self) -> str:
        return str(self.summary())

    def _repr_html_(self) -> str:
        return str(self.summary().to_html())


# ---- Plain numbers of results

# What is smaller, in its unit, is nothing: a solver leaves such payloads, and no change is relative
# to it.
NEGLIGIBLE = 1e-6

# As reports on solar power have them: P90 is exceeded in 90 % of all cases.
PERCENTILES = {"p90": 10.0, "p50": 50.0, "p10": 90.0}


def finite(value: Any) -> float | None:
    """Return a number for JSON: null where it is infinite, not defined or missing."""
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None


def relative_change(before: float, after: float) -> float | None:
    """Return a change over the value before it [-]; None where that was next to nothing."""
    return None if abs(before) <= NEGLIGIBLE else (after - before) / before


def percentiles(values: FloatArray | list[float], method: Any = "inverted_cdf") -> dict[str, float]:
    """Return P90, which 90 % of cases exceed, P50 and P10.

    By default each is a value that occurred.
    """
    import numpy as np  # which lists of names do without

    return {
        name: float(np.percentile(values, at, method=method)) for name, at in PERCENTILES.items()
    }
