"""Size, resolution and style of figures as a user asks for them; matplotlib only where it must be.

A style is a shipped name, a name of matplotlib, or a file in the format of matplotlib's
``.mplstyle``.
"""

from __future__ import annotations

import math
import os
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

DOTS_PER_INCH = 150
# Settings of matplotlib are those of the process: one figure at a time.
SETTINGS = threading.RLock()

SHIPPED_STYLES = ("default", "paper", "slides", "dark")

_MM_PER_INCH = 25.4
_UNITS_PER_INCH = {"mm": _MM_PER_INCH, "cm": _MM_PER_INCH / 10.0, "in": 1.0}
_SIZE = re.compile(
    r"(?P<width>\d+(?:\.\d+)?)\s*(?:[xX×]\s*(?P<height>\d+(?:\.\d+)?)\s*)?(?P<unit>mm|cm|in)"
)
_BEFORE_COMMENT = re.compile(r'(?:[^"#]|"[^"]*")*')
_LEAST_MM, _MOST_MM = 40.0, 2500.0
_LEAST_DPI, _MOST_DPI = 20.0, 2400.0
_MOST_DOTS = 2**16  # on either side: what matplotlib's renderer takes
_MOST_DOTS_IN_ALL = 150_000_000  # A0 at 300 dots per inch; some 650 MB while it is drawn
_SMALLEST_TYPE = 5.0  # [pt], which journals still print
_TYPE_PER_INCH = 2.6  # [pt] of the shorter side, at most: small figures have smaller type
_MOST_STYLE_BYTES = 100_000
_LEAST_TYPE, _MOST_TYPE, _MOST_LENGTH = 1.0, 100.0, 1000.0  # points
# Settings of matplotlib that have nothing to do with looks, and that it leaves out of a style.
_NO_STYLE = re.compile(
    r"(backend|interactive|toolbar|timezone|webagg|tk|docstring|date\.epoch|savefig\.directory"
    r"|figure\.(max_open_warning|raise_window))\b"
)


class TooManyDotsError(ValueError):
    """An image is larger than can be drawn."""


@dataclass(frozen=True)
class FigureOptions:
    """How a figure is to look.

    Parameters
    ----------
    size_in : (float, float or None), optional
        Width and height [in]; without a height the figure has the one that its content takes, and
        without either its own size.
    dots_per_inch : float, optional
        Resolution of PNG, and of images within SVG and PDF; by default 150.
    style : str
        Name of a shipped style or of one of matplotlib's, or a file.
    title : bool
        Whether title and subtitle stand over the figure.

    Raises
    ------
    ValueError
        If a size or a resolution is out of range, or both together ask for too many dots.
    """

    size_in: tuple[float, float | None] | None = None
    dots_per_inch: float | None = None
    style: str = "default"
    title: bool = True

    def __post_init__(self) -> None:
        for side in self.size_in or ():
            if side is not None and not _LEAST_MM <= round(side * _MM_PER_INCH, 6) <= _MOST_MM:
                raise ValueError(
                    f"width and height must be from {_LEAST_MM:g} to {_MOST_MM:g} mm "
                    f"(got {side * _MM_PER_INCH:g} mm)"
                )
        dots = self.dots_per_inch
        if dots is None:
            return
        if not _LEAST_DPI <= dots <= _MOST_DPI:
            raise ValueError(f"must be from {_LEAST_DPI:g} to {_MOST_DPI:g} (got {dots:g})")
        width, height = self.size_in or (0.0, None)
        check_dots(width, width if height is None else height, dots)

    def settings(self) -> dict[str, Any]:
        """Return the settings of the style, in the names of matplotlib's ``rcParams``.

        Raises
        ------
        ValueError
            If there is no such style, or its file is not one.
        """
        settings = style_settings("default")
        if self.style != "default":
            settings |= style_settings(self.style)
        if self.size_in is not None:
            usual = settings.get("font.size", 10.0)
            settings["font.size"] = type_within(usual, *filter(None, self.size_in))
        return settings


DEFAULT = FigureOptions()


def type_within(usual_pt: float, *size_in: float) -> float:
    """Return the size of the type [pt] of a drawing of some width and height, if it is known."""
    return min(usual_pt, max(_TYPE_PER_INCH * min(size_in), _SMALLEST_TYPE))


def ignore_settings_of_folder() -> None:
    """Keep matplotlib from reading a ``matplotlibrc`` in the current folder.

    It does so when it is imported, and fails on some; nothing turns that off. To be called before
    there are threads. Nothing is imported where there is no such file.
    """
    if not os.path.lexists("matplotlibrc"):
        return
    here = Path.cwd()
    os.chdir(here.anchor)
    try:
        import matplotlib  # noqa: F401
    finally:
        os.chdir(here)


def check_dots(width_in: float, height_in: float, dots_per_inch: float) -> None:
    """Check that an image can be drawn."""
    longest = max(width_in, height_in)
    if longest * dots_per_inch >= _MOST_DOTS:
        raise TooManyDotsError(
            f"{longest * _MM_PER_INCH:g} mm at {dots_per_inch:g} dots per inch are "
            f"{longest * dots_per_inch:.0f} dots, at most {_MOST_DOTS - 1} can be drawn"
        )
    in_all = width_in * height_in * dots_per_inch**2
    if in_all > _MOST_DOTS_IN_ALL:
        raise TooManyDotsError(
            f"{width_in * _MM_PER_INCH:.4g} x {height_in * _MM_PER_INCH:.4g} mm at "
            f"{dots_per_inch:g} dots per inch are {in_all / 1e6:.0f} million dots, at most "
            f"{_MOST_DOTS_IN_ALL / 1e6:.0f} million can be drawn (SVG and PDF need no dots)"
        )


def read_size(text: str) -> tuple[float, float | None]:
    """Read ``170x100mm``, ``17x10cm``, ``7x4in``, or a width alone, such as ``85mm``.

    Returns width and height [in].
    """
    if (match := _SIZE.fullmatch(text.strip())) is None:
        raise ValueError(
            f"{text!r} is no size of a figure; allowed: WIDTHxHEIGHT or WIDTH with mm, cm or in, "
            "for example 170x100mm, 7x4in or 85mm"
        )
    per_inch, height = _UNITS_PER_INCH[match["unit"]], match["height"]
    size_in = float(match["width"]) / per_inch, float(height) / per_inch if height else None
    FigureOptions(size_in=size_in)
    return size_in


def read_dots_per_inch(text: str) -> float:
    """Read a resolution."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if math.isnan(number):
        raise ValueError(f"{text!r} is no number of dots per inch, for example 300")
    FigureOptions(dots_per_inch=number)
    return number


def library() -> Any:
    """Return matplotlib, which takes half a second to import."""
    import matplotlib.style

    return matplotlib


@contextmanager
def in_style(options: FigureOptions) -> Iterator[None]:
    """Draw in a style, whatever settings the machine has; one thread at a time."""
    with SETTINGS, library().style.context(["default", options.settings()]):
        yield


def style_settings(style: str) -> dict[str, Any]:
    """Return the settings of a shipped style, one of matplotlib's, or a file."""
    if style in SHIPPED_STYLES:
        from importlib import resources  # which a page of help does not need

        place = resources.files("studies.output.figures") / "styles" / f"{style}.mplstyle"
        return _settings_of_file(place.read_text(encoding="utf-8"), style)
    known_styles: dict[str, Any] = library().style.library
    if style in known_styles:
        return dict(known_styles[style])
    path = Path(style)
    try:
        if not path.is_file() or path.stat().st_size > _MOST_STYLE_BYTES:
            raise OSError  # neither a pipe that never ends
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError, ValueError):
        known = ", ".join(SHIPPED_STYLES)
        raise ValueError(
            f"{style!r} is neither a style nor a file of one; allowed: {known}, the styles of "
            "matplotlib such as grayscale, or an .mplstyle file"
        ) from None
    return _settings_of_file(text, style)


def _settings_of_file(text: str, source: str) -> dict[str, Any]:
    """Return the settings of a file; a mistake in it is an error."""
    mpl = library()
    parameters = mpl.RcParams()
    for number, line in enumerate(text.splitlines(), 1):
        content = _BEFORE_COMMENT.match(line)[0]  # type: ignore[index]  # matches any text
        if not content.strip():
            continue
        key, colon, value = (part.strip() for part in content.partition(":"))
        if not colon:
            raise ValueError(f"{source}:{number}: {content.strip()!r} is not KEY: VALUE")
        if key not in mpl.rcParams:
            raise ValueError(f"{source}:{number}: {key}: matplotlib has no such setting")
        if _NO_STYLE.match(key):
            raise ValueError(f"{source}:{number}: {key}: has nothing to do with style")
        if value[:1] == value[-1:] == '"':
            value = value[1:-1]
        try:
            parameters[key] = value
        except ValueError as error:
            raise ValueError(f"{source}:{number}: {key}: {error}") from None
        _check_lengths(key, parameters[key], f"{source}:{number}: {key}")
    return dict(parameters)


def _check_lengths(key: str, value: Any, where: str) -> None:
    """Refuse numbers that matplotlib takes and cannot draw."""
    if isinstance(value, list | tuple):
        for item in value:
            _check_lengths(key, item, where)
        return
    least, most, allowed = -math.inf, math.inf, "a finite number"
    if key == "font.size":
        least, most = _LEAST_TYPE, _MOST_TYPE
        allowed = f"from {least:g} to {most:g}"
    elif key.endswith(("size", "width", "pad")):
        most = _MOST_LENGTH
        allowed = f"at most {most:g}"
    if isinstance(value, int | float) and not (math.isfinite(value) and least <= value <= most):
        raise ValueError(f"{where}: must be {allowed} (got {value:g})")
