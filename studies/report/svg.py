"""Drawings as SVG text: elements with escaped attributes, polylines, dimensions."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

Point = tuple[float, float]

_ARROW_LENGTH, _ARROW_WIDTH = 7.0, 2.2


def element(
    name: str, content: str = "", attributes: Mapping[str, str | float | None] | None = None
) -> str:
    """Write an SVG element.

    ``attributes``: by name; None leaves one out. Texts are escaped.
    """
    written = "".join(
        f' {key}="{html.escape(_attribute_text(value))}"'
        for key, value in (attributes or {}).items()
        if value is not None
    )
    return f"<{name}{written}>{content}</{name}>" if content else f"<{name}{written}/>"


def _attribute_text(value: str | float) -> str:
    """Attribute as text: coordinates with a hundredth of a pixel, and no minus zero."""
    return value if isinstance(value, str) else f"{round(value, 2) + 0.0:g}"


@dataclass
class Canvas:
    """A drawing in pixels, x to the right and y down.

    ``height``: height [px]; may be set when everything is drawn.
    """

    width: float
    height: float = 0.0
    parts: list[str] = field(default_factory=list)

    def shape(self, points: Iterable[Point], kind: str, *, closed: bool = True) -> None:
        """Draw a polygon, or a line through points.

        ``closed``: whether the last point is joined to the first.
        """
        places = " ".join(f"{_attribute_text(x)},{_attribute_text(y)}" for x, y in points)
        name = "polygon" if closed else "polyline"
        self.parts.append(element(name, "", {"class": kind, "points": places}))

    def line(self, start: Point, end: Point, kind: str) -> None:
        """Draw a straight line."""
        self.shape((start, end), kind, closed=False)

    def text(self, place: Point, text: str, kind: str = "label", *, anchor: str = "middle") -> None:
        """Write a text."""
        attributes: dict[str, str | float | None] = {
            "class": kind,
            "x": place[0],
            "y": place[1],
            "text-anchor": anchor,
        }
        self.parts.append(element("text", html.escape(text), attributes))

    def dimension(self, start: Point, end: Point, text: str) -> None:
        """Draw a dimension, level or upright, with arrows and its text beside it."""
        (x0, y0), (x1, y1) = start, end
        length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
        along = ((x1 - x0) / length, (y1 - y0) / length) if length else (1.0, 0.0)
        inside = length > 4.0 * _ARROW_LENGTH
        self.line(start, end, "dimension")
        for place, sign in ((start, 1.0), (end, -1.0)):
            self._arrow(place, along, sign if inside else -sign)
        if y0 == y1:
            self.text(((x0 + x1) / 2.0, y0 - 5.0), text, "value")
        else:
            self.text((x0 + 7.0, (y0 + y1) / 2.0 + 4.0), text, "value", anchor="start")

    def _arrow(self, tip: Point, along: Point, sign: float) -> None:
        ux, uy = sign * along[0], sign * along[1]
        base = (tip[0] + _ARROW_LENGTH * ux, tip[1] + _ARROW_LENGTH * uy)
        sides = [(base[0] - w * uy, base[1] + w * ux) for w in (_ARROW_WIDTH, -_ARROW_WIDTH)]
        self.shape([tip, *sides], "arrow")

    def markup(self, *, title: str, description: str, key: str, classes: Sequence[str]) -> str:
        """Write the drawing as an element of a page."""
        told = element("title", html.escape(title), {"id": f"{key}-title"})
        told += element("desc", html.escape(description), {"id": f"{key}-desc"})
        attributes: dict[str, str | float | None] = {
            "class": " ".join(classes),
            "role": "img",
            "aria-labelledby": f"{key}-title {key}-desc",
            "viewBox": f"0 0 {_attribute_text(self.width)} {_attribute_text(self.height)}",
            "width": self.width,
            "height": self.height,
        }
        return element("svg", told + "".join(self.parts), attributes)
