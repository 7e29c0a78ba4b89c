"""Three views of an aircraft to scale: from above, from ahead, from the left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from studies.output.figures.drawing import (
    DARK_GREY,
    GREY,
    LOAD,
    VERMILLION,
    Canvas,
    add_legend,
    ink,
    new_figure,
    paper,
    styled,
)
from studies.output.figures.options import DEFAULT
from studies.report.geometry import Drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Thickness of a symmetrical four-digit section over its chord, at full thickness ratio one
# (Abbott & von Doenhoff, Theory of Wing Sections, section 6.4).
_SECTION = (1.4845, -0.63, -1.758, 1.4215, -0.5075)
_WIDTH_IN = 8.0
_AROUND = 0.1  # of what is drawn, to either side of it: for dimensions
_THIN: dict[str, Any] = {"color": DARK_GREY, "linewidth": 0.6}
_SHORT = 0.45  # length over wingspan
_BETWEEN_IN = 0.25  # of views: their headings and dimensions

Points = Sequence[tuple[float, float]]


class _View:
    """A view in metres; parts that no model has numbers for are dashed.

    ``unit_m``: a hundredth of the width.
    """

    def __init__(self, axes: Axes, drawing: Drawing, unit_m: float) -> None:
        self.axes, self.drawing, self.unit_m = axes, drawing, unit_m

    def shape(self, points: Any, part: str, fill: str = GREY, **looks: Any) -> None:
        """Draw an outline; ``part``: what of the drawing it belongs to."""
        dashed = "--" if part in self.drawing.schematic else "-"
        looks = {"edgecolor": ink(), "linewidth": 0.8, "linestyle": dashed, **looks}
        self.axes.add_patch(Polygon(np.asarray(points), facecolor=fill, gid=part, **looks))

    def box(
        self, left: float, right: float, low: float, high: float, part: str, **looks: Any
    ) -> None:
        """Draw a rectangle."""
        self.shape([(left, low), (right, low), (right, high), (left, high)], part, **looks)

    def line(self, points: Points, **looks: Any) -> None:
        """Draw a line that is no edge of anything."""
        self.axes.plot(*np.transpose(points), **(_THIN | looks))

    def dimension(self, start: tuple[float, float], end: tuple[float, float], text: str) -> None:
        """Draw an arrow from end to end, and a length beside it."""
        arrow = {"arrowstyle": "<->", "color": DARK_GREY, "shrinkA": 0, "shrinkB": 0}
        self.axes.annotate("", end, start, arrowprops=arrow)
        level = start[1] == end[1]
        middle = ((start[0] + end[0]) / 2.0, (start[1] + end[1]) / 2.0)
        self.note(middle, text, (0, 2) if level else (4, 0), "center" if level else "left")

    def note(
        self, place: tuple[float, float], text: str, shift: tuple[float, float], ha: str
    ) -> None:
        """Write a text a few points beside a place."""
        self.axes.annotate(
            text,
            place,
            shift,
            textcoords="offset points",
            ha=ha,
            va="bottom" if ha == "center" else "center",
            fontsize="small",
        )


@styled
def plot_three_view(
    drawing: Drawing,
    *,
    gravity_m: float | None = None,
    neutral_m: float | None = None,
    figure: Canvas = DEFAULT,
) -> Figure:
    """Draw three views at one scale with dimensions, below each other.

    ``gravity_m``, ``neutral_m``: centre of gravity and neutral point behind the leading edge of the
    wing root, where known [m].
    """
    length_m = drawing.nose_m + drawing.tail_end_m
    width_m = (1.0 + 2.0 * _AROUND) * max(drawing.wingspan_m, length_m)
    pad_m = 0.04 * width_m
    low_m, high_m = _heights(drawing)
    middle_m, half_m = (drawing.tail_end_m - drawing.nose_m) / 2.0, width_m / 2.0
    rear_m = -drawing.tail_end_m - 0.3 * pad_m
    limits = (
        ("Top", (-half_m, half_m), (rear_m, drawing.nose_m + pad_m)),
        ("Front", (-half_m, half_m), (low_m, high_m)),
        ("Left side", (middle_m - half_m, middle_m + half_m), (low_m - pad_m, high_m)),
    )
    tall_m = [top - bottom for _, _, (bottom, top) in limits]
    per_m = _WIDTH_IN / width_m
    drawn, panels = new_figure(
        rows=3,
        canvas=figure,
        size_in=(_WIDTH_IN, per_m * sum(tall_m) + 3.0 * _BETWEEN_IN),
        grid="",
        height_ratios=tall_m,
    )
    views = []
    for axes, (title, across, along) in zip(panels, limits, strict=True):
        axes.set(xlim=across, ylim=along, aspect="equal")
        axes.set_axis_off()
        axes.set_title(title, loc="left")
        views.append(_View(axes, drawing, 0.01 * width_m))
    _draw_above(views[0])
    _draw_ahead(views[1])
    _draw_left(views[2])
    points = {"centre of gravity": (gravity_m, "o"), "neutral point": (neutral_m, "D")}
    known = {name: point for name, point in points.items() if point[0] is not None}
    for name, (aft_m, marker) in known.items():
        views[0].line([(0.0, -float(aft_m or 0.0))], marker=marker, markersize=6, color=ink(),
                      markerfacecolor=ink() if marker == "o" else paper(), label=name)  # fmt: skip
    entries = _legend(drawing, panels[0])
    if length_m < _SHORT * drawing.wingspan_m:  # room beside the view from the left
        panels[2].legend(handles=entries, loc="center right", frameon=False)
    else:
        add_legend(drawn, entries, 3)
    return drawn


def description(
    drawing: Drawing, *, gravity_m: float | None = None, neutral_m: float | None = None
) -> str:
    """Return what the drawing shows in words; points as :func:`plot_three_view` has them."""
    points = {"centre of gravity": gravity_m, "neutral point": neutral_m}
    tail = drawing.tail
    dihedral = (
        f"flat to {drawing.dihedral_from_m:.2f} m from the middle and raised by "
        f"{drawing.dihedral_deg:g} degrees outside"
        if drawing.dihedral_deg
        else "without dihedral"
    )
    return (
        f"Views from above, from ahead and from the left at one scale. Wing of "
        f"{drawing.wingspan_m:.2f} m span and {drawing.chord_m:.3f} m chord, {dihedral}; "
        f"{len(drawing.modules)} {drawing.modules_are}; horizontal tail of "
        f"{tail.horizontal_span_m:.2f} by {tail.horizontal_chord_m:.2f} m, its leading edge "
        f"{tail.horizontal_aft_m:.2f} m behind that of the wing; vertical tail "
        f"{abs(tail.vertical_height_m):.2f} m high."
        + "".join(
            f" The {point} lies {place:.3f} m behind the leading edge of the wing root."
            for point, place in points.items()
            if place is not None
        )
    )


def _fin_heights(drawing: Drawing) -> tuple[float, float]:
    """Return the lower and upper end of the fins over the wing root."""
    ends = drawing.tail.boom_height_m, drawing.tail.boom_height_m + drawing.tail.vertical_height_m
    return min(ends), max(ends)


def _heights(drawing: Drawing) -> tuple[float, float]:
    """Return the lowest and highest point, with a little room."""
    pod, room = drawing.pod_depth_m / 2.0, 0.25 * drawing.chord_m
    low, high = _fin_heights(drawing)
    tip = drawing.height_m(drawing.wingspan_m / 2.0)
    return min(low, -pod) - room, max(high, drawing.tail.height_m, tip, pod) + room


def _ellipse(middle: float, half_width: float, half_height: float, up: float = 0.0) -> Points:
    angles = np.linspace(0.0, 2.0 * np.pi, 41)
    return list(
        zip(middle + half_width * np.cos(angles), up + half_height * np.sin(angles), strict=True)
    )


def _draw_above(view: _View) -> None:
    """Draw the plan view, whose ordinate is forward of the leading edge of the root."""
    drawing, tail, half = view.drawing, view.drawing.tail, view.drawing.wingspan_m / 2.0
    boom, side = drawing.boom_m / 2.0, tail.horizontal_span_m / 2.0
    fin = -tail.vertical_aft_m
    for place in drawing.booms_m:
        view.box(place - boom, place + boom, -drawing.tail_end_m, 0.0, "tail", fill=paper())
    middle = drawing.nose_m - drawing.pod_m / 2.0
    view.shape(
        _ellipse(0.0, drawing.pod_depth_m / 2.0, drawing.pod_m / 2.0, middle), "pod", paper()
    )
    front, rear = -tail.horizontal_aft_m, -tail.horizontal_aft_m - tail.horizontal_chord_m
    view.box(-side, side, rear, front, "tail")
    for place in drawing.booms_m:
        view.line(
            [(place, fin), (place, fin - tail.vertical_chord_m)],
            color=ink(),
            linewidth=1.4,
            gid="fin",
        )
    leading = [(y, -front) for y, front, _ in drawing.outline]
    view.shape([*leading, *((y, -rear) for y, _, rear in reversed(drawing.outline))], "wing")
    for m in drawing.modules:
        looks = {"edgecolor": LOAD, "linewidth": 0.5, "alpha": 0.6}
        view.box(m.left_m, m.right_m, -m.rear_m, -m.front_m, "modules", fill=LOAD, **looks)
    dashed = "--" if "spar" in drawing.schematic else "-"
    view.line(
        [(-half, -drawing.spar_m), (half, -drawing.spar_m)], color=VERMILLION, linestyle=dashed
    )
    for place in (
        (-drawing.dihedral_from_m, drawing.dihedral_from_m) if drawing.dihedral_deg else ()
    ):
        view.line([(place, 0.0), (place, -drawing.chord_m)])
    over = max(drawing.nose_m, 2.0 * view.unit_m) + 2.0 * view.unit_m
    view.dimension((-half, over), (half, over), f"{drawing.wingspan_m:.2f} m")
    right_of_tip, lead = half + 1.5 * view.unit_m, -drawing.front_at(half)
    tip_m = drawing.chord_at(half)
    view.dimension((right_of_tip, lead), (right_of_tip, lead - tip_m), f"{tip_m:.3f} m")
    arm = side + 2.0 * view.unit_m
    view.dimension((arm, 0.0), (arm, front), f"{tail.horizontal_aft_m:.2f} m")
    size = f"{tail.horizontal_span_m:.2f} × {tail.horizontal_chord_m:.2f} m"
    view.note((-side, (front + rear) / 2.0), size, (-5, 0), "right")


def _draw_ahead(view: _View) -> None:
    """Draw the view from ahead: right, and up from the wing root."""
    drawing, tail, half = view.drawing, view.drawing.tail, view.drawing.wingspan_m / 2.0
    right = sorted({drawing.dihedral_from_m, *(y for y, _ in drawing.chords[1:-1]), half})
    places = np.array([*(-y for y in reversed(right)), *right])
    up = np.array([drawing.height_m(y) for y in places])
    thick = np.array([drawing.thickness_ratio * drawing.chord_at(y) / 2.0 for y in places])
    low, high = _fin_heights(drawing)
    fin = drawing.thickness_ratio * tail.vertical_chord_m / 2.0
    for y in drawing.booms_m:
        view.box(y - fin, y + fin, low, high, "tail")
    plane, side = (
        drawing.thickness_ratio * tail.horizontal_chord_m / 2.0,
        tail.horizontal_span_m / 2.0,
    )
    view.box(-side, side, tail.height_m - plane, tail.height_m + plane, "tail")
    upper = zip(places, up + thick, strict=True)
    view.shape([*upper, *zip(places[::-1], (up - thick)[::-1], strict=True)], "wing")
    radius = drawing.pod_depth_m / 2.0
    view.shape(_ellipse(0.0, radius, radius), "pod", paper())
    if drawing.dihedral_deg:
        view.note((half, float(up[-1])), f"{drawing.dihedral_deg:g}°", (5, 0), "left")


def _draw_left(view: _View) -> None:
    """Draw the view from the left: aft of the leading edge of the root, and up."""
    drawing, tail = view.drawing, view.drawing.tail
    low, high = _fin_heights(drawing)
    root, boom = tail.boom_height_m, drawing.boom_m / 2.0
    view.box(0.0, drawing.tail_end_m, root - boom, root + boom, "tail", fill=paper())
    middle = drawing.pod_m / 2.0 - drawing.nose_m
    view.shape(_ellipse(middle, drawing.pod_m / 2.0, drawing.pod_depth_m / 2.0), "pod", paper())
    fin_rear = tail.vertical_aft_m + tail.vertical_chord_m
    view.box(tail.vertical_aft_m, fin_rear, low, high, "tail")
    plane = tail.horizontal_chord_m * _section(drawing.thickness_ratio, 0.0)
    view.shape(plane + np.array([tail.horizontal_aft_m, tail.height_m]), "tail")
    section = _section(drawing.thickness_ratio, drawing.incidence_deg)
    for right_m in (drawing.wingspan_m / 2.0, 0.0) if drawing.dihedral_deg else (0.0,):
        place = np.array([drawing.front_at(right_m), drawing.height_m(right_m)])
        view.shape(
            drawing.chord_at(right_m) * section + place, "section", "none" if right_m else GREY
        )
    right = max(fin_rear, drawing.tail_end_m) + 1.5 * view.unit_m
    view.dimension((right, low), (right, high), f"{high - low:.2f} m")
    under = min(low, -drawing.pod_depth_m / 2.0) - 3.0 * view.unit_m
    view.dimension((0.0, under), (drawing.tail_end_m, under), f"{drawing.tail_end_m:.2f} m")


def _section(thickness_ratio: float, incidence_deg: float) -> Any:
    """Return the outline of a symmetrical section of chord one, aft and up."""
    x = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 25)))
    root, *powers = _SECTION
    half = thickness_ratio * (
        root * np.sqrt(x) + sum(a * x ** (i + 1) for i, a in enumerate(powers))
    )
    outline = np.concatenate([np.stack([x, half], axis=1), np.stack([x, -half], axis=1)[::-1]])
    pitch = np.radians(incidence_deg)
    turn = np.array([[np.cos(pitch), -np.sin(pitch)], [np.sin(pitch), np.cos(pitch)]])
    return outline @ turn


def _legend(drawing: Drawing, axes: Axes) -> list[Any]:
    """Return the entries of the legend: modules, spar, schematic parts, points."""
    modules = [Patch(facecolor=LOAD, alpha=0.6, label=drawing.modules_are)]
    return [
        *(modules if drawing.modules else []),
        Line2D([], [], color=VERMILLION, label="spar"),
        Patch(facecolor="none", edgecolor=ink(), linestyle="--", label="schematic"),
        *axes.get_legend_handles_labels()[0],
    ]
