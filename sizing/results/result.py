"""What all results are: plain numbers, which the layer above renders and serialises."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd


def data_frame(data: Any, columns: list[str] | None = None) -> pd.DataFrame:
    """Return a frame of pandas, whose import takes longer than most results themselves."""
    import pandas as pd

    return pd.DataFrame(data, columns=columns)


RENDERER, SERIALISER = "studies.render.results", "studies.serialise"


class Result:
    """A result: plain numbers, which the layer above renders and serialises.

    Results know of it no more than the names :data:`RENDERER` and :data:`SERIALISER`, by which it
    is imported when somebody looks at a result.
    """

    def headline(self) -> str:
        """Return the result in one line."""
        return str(import_module(RENDERER).headline(self))

    def summary(self) -> Any:
        """Return the :class:`studies.Summary` of the result that fits a screen."""
        return self.at_level(1)

    def at_level(self, level: int) -> Any:
        """Return a :class:`studies.Summary` of the result: short at level 1, all of it at 2."""
        return import_module(RENDERER).render(self, level)

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
