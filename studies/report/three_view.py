"""Three views of an aircraft to scale: from above, from ahead, from the left."""

from __future__ import annotations

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
    arrow,
    box,
    ink,
    new_figure,
    note,
    paper,
    styled,
)
from studies.output.figures.options import DEFAULT
from studies.render.words import amount, given
from studies.report.geometry import Drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Thickness of a symmetrical four-digit section over its chord, at full thickness ratio one
# (Abbott & von Doenhoff, Theory of Wing Sections, section 6.4).
_SECTION = (1.4845, -0.63, -1.758, 1.4215, -0.5075)
# Looks alone, in chords: nose ahead of the leading edge, pod and its depth; the spar lies where a
# section is thickest, as in the rib wing's model.
_NOSE, _POD, _DEPTH, _SPAR = 0.7, 2.2, 0.32, 0.3
_WIDTH_IN, _BETWEEN_IN = 8.0, 0.27  # headings, dimensions and legend of each view
_AROUND = 1.2  # width over what is drawn
_ROOM = 0.024  # of the width, between what is drawn and a dimension


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
    nose_m, aft_m = _NOSE * drawing.chord_m, drawing.tail_end_m
    width_m = _AROUND * max(drawing.wingspan_m, nose_m + aft_m)
    room_m, half_m, middle_m = _ROOM * width_m, width_m / 2.0, (aft_m - nose_m) / 2.0
    low_m, high_m = _heights(drawing)
    limits = (
        ("Top", -half_m, -aft_m - room_m, nose_m + 2.0 * room_m),
        ("Front", -half_m, low_m - room_m, high_m + room_m),
        ("Left side", middle_m - half_m, low_m - 2.0 * room_m, high_m + room_m),
    )
    tall_m = [top - bottom for _, _, bottom, top in limits]
    drawn, panels = new_figure(
        rows=3,
        canvas=figure,
        size_in=(_WIDTH_IN, _WIDTH_IN / width_m * sum(tall_m) + 3.0 * _BETWEEN_IN),
        grid="",
        height_ratios=tall_m,
    )
    for axes, (title, left, bottom, top) in zip(panels, limits, strict=True):
        axes.set(xlim=(left, left + width_m), ylim=(bottom, top), aspect="equal")
        axes.set_axis_off()
        axes.set_title(title, loc="left")
    _draw_above(panels[0], drawing, room_m)
    _draw_ahead(panels[1], drawing)
    _draw_left(panels[2], drawing, room_m)
    looks: dict[str, Any] = {"color": ink(), "markersize": 6, "linestyle": ""}
    for name, place_m, marker, fill in (
        ("centre of gravity", gravity_m, "o", ink()),
        ("neutral point", neutral_m, "D", paper()),
    ):
        if place_m is not None:
            looks |= {"marker": marker, "markerfacecolor": fill}
            panels[0].plot([0.0], [-place_m], label=name, **looks)
    entries = [
        *(Patch(facecolor=LOAD, alpha=0.6, label=drawing.modules_are) for _ in drawing.modules[:1]),
        Line2D([], [], color=VERMILLION, label="spar"),
        Patch(facecolor="none", edgecolor=ink(), linestyle="--", label="schematic"),
        *panels[0].get_legend_handles_labels()[0],
    ]
    add_legend(drawn, entries, len(entries), frameon=False)
    return drawn


def description(drawing: Drawing) -> str:
    """Return what the drawing shows in words."""
    tail = drawing.tail
    return (
        f"Views from above, from ahead and from the left at one scale. Wing of "
        f"{amount(drawing.wingspan_m, 'm')} span and {amount(drawing.chord_m, 'm')} chord, "
        f"dihedral {given(drawing.dihedral_deg)} degrees; {len(drawing.modules)} "
        f"{drawing.modules_are}; horizontal tail of {amount(tail.horizontal_span_m, 'm')} by "
        f"{amount(tail.horizontal_chord_m, 'm')}, {amount(tail.horizontal_aft_m, 'm')} behind the "
        f"leading edge of the wing; vertical tail {amount(abs(tail.vertical_height_m), 'm')} high."
    )


def _fin_heights(drawing: Drawing) -> tuple[float, float]:
    """Return the lower and upper end of the fins over the wing root."""
    ends = drawing.tail.boom_height_m, drawing.tail.boom_height_m + drawing.tail.vertical_height_m
    return min(ends), max(ends)


def _heights(drawing: Drawing) -> tuple[float, float]:
    """Return the lowest and highest point."""
    pod, tip = _DEPTH * drawing.chord_m / 2.0, drawing.height_m(drawing.wingspan_m / 2.0)
    low, high = _fin_heights(drawing)
    return min(low, -pod), max(high, drawing.tail.height_m, tip, pod)


# ---- Shapes


def _shape(
    axes: Axes, drawing: Drawing, part: str, points: Any, fill: str = GREY, **looks: Any
) -> None:
    """Draw an outline; parts that no model has numbers for are dashed."""
    dashed = "--" if part in drawing.schematic else "-"
    looks = {"edgecolor": ink(), "linewidth": 0.8, "linestyle": dashed, **looks}
    axes.add_patch(Polygon(np.asarray(points), facecolor=fill, gid=part, **looks))


def _ellipse(x: float, y: float, width: float, height: float) -> Any:
    angle = np.linspace(0.0, 2.0 * np.pi, 41)
    return np.stack([x + width / 2.0 * np.cos(angle), y + height / 2.0 * np.sin(angle)], axis=1)


def _section(thickness_ratio: float, incidence_deg: float = 0.0) -> Any:
    """Return the outline of a symmetrical section of chord one, aft and up."""
    x = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 25)))
    root, *powers = _SECTION
    half = thickness_ratio * (root * np.sqrt(x) + x * np.polyval(powers[::-1], x))
    outline = np.concatenate([np.stack([x, half], axis=1), np.stack([x, -half], axis=1)[::-1]])
    pitch = np.radians(incidence_deg)
    return outline @ [[np.cos(pitch), -np.sin(pitch)], [np.sin(pitch), np.cos(pitch)]]


def _dimension(axes: Axes, x: float, y: float, right: float, up: float) -> None:
    """Draw an arrow from a place so far to the right and up, and its length beside it."""
    arrow(axes, (x, y), (x + right, y + up), DARK_GREY)
    text, middle = amount(max(abs(right), abs(up)), "m"), (x + right / 2.0, y + up / 2.0)
    if right:
        note(axes, text, middle, (0, 2), ha="center", va="bottom")
    else:
        note(axes, text, middle, (4, 0), ha="left", va="center")


# ---- Views


def _draw_above(axes: Axes, drawing: Drawing, room_m: float) -> None:
    """Draw the plan view, whose ordinate is forward of the leading edge of the root."""
    tail, half, chord = drawing.tail, drawing.wingspan_m / 2.0, drawing.chord_m
    boom, side = drawing.boom_m / 2.0, tail.horizontal_span_m / 2.0
    for y in drawing.booms_m:
        boom_shape = box(y - boom, y + boom, -drawing.tail_end_m, 0.0)
        _shape(axes, drawing, "tail", boom_shape, paper())
    pod = _ellipse(0.0, (_NOSE - _POD / 2.0) * chord, _DEPTH * chord, _POD * chord)
    _shape(axes, drawing, "pod", pod, paper())
    front, rear = -tail.horizontal_aft_m, -tail.horizontal_aft_m - tail.horizontal_chord_m
    _shape(axes, drawing, "tail", box(-side, side, rear, front))
    fin = (-tail.vertical_aft_m, -tail.vertical_aft_m - tail.vertical_chord_m)
    axes.plot([drawing.booms_m] * 2, fin, color=ink(), linewidth=1.4, gid="fin")
    leading = [(y, -edge) for y, edge, _ in drawing.outline]
    trailing = [(y, -edge) for y, _, edge in reversed(drawing.outline)]
    _shape(axes, drawing, "wing", [*leading, *trailing])
    looks = {"edgecolor": LOAD, "linewidth": 0.5, "alpha": 0.6}
    for m in drawing.modules:
        points = box(m.left_m, m.right_m, -m.rear_m, -m.front_m)
        _shape(axes, drawing, "modules", points, LOAD, **looks)
    dashed = "--" if "spar" in drawing.schematic else "-"
    axes.plot([-half, half], [-_SPAR * chord] * 2, color=VERMILLION, linewidth=0.6, ls=dashed)
    if drawing.dihedral_deg:
        bends = [-drawing.dihedral_from_m, drawing.dihedral_from_m]
        axes.vlines(bends, -chord, 0.0, color=DARK_GREY, linewidth=0.6)
    _dimension(axes, -half, _NOSE * chord + room_m / 2.0, drawing.wingspan_m, 0.0)
    tip = -drawing.front_at(half)
    _dimension(axes, half + room_m / 2.0, tip, 0.0, -drawing.chord_at(half))
    _dimension(axes, side + room_m / 2.0, 0.0, 0.0, front)
    size = " × ".join(amount(m, "m") for m in (tail.horizontal_span_m, tail.horizontal_chord_m))
    note(axes, size, (-side, (front + rear) / 2.0), (-5, 0), ha="right", va="center")


def _draw_ahead(axes: Axes, drawing: Drawing) -> None:
    """Draw the view from ahead: right, and up from the wing root."""
    tail, half, thick = drawing.tail, drawing.wingspan_m / 2.0, drawing.thickness_ratio
    right = {drawing.dihedral_from_m, *(y for y, _ in drawing.chords[1:-1]), half}
    places = np.array(sorted({-y for y in right} | right))
    up = np.array([drawing.height_m(y) for y in places])
    upper = up + [thick * drawing.chord_at(y) / 2.0 for y in places]
    low, high = _fin_heights(drawing)
    fin, plane = thick * tail.vertical_chord_m / 2.0, thick * tail.horizontal_chord_m / 2.0
    for y in drawing.booms_m:
        _shape(axes, drawing, "tail", box(y - fin, y + fin, low, high))
    side, height = tail.horizontal_span_m / 2.0, tail.height_m
    _shape(axes, drawing, "tail", box(-side, side, height - plane, height + plane))
    outline = np.concatenate([[places, upper], [places[::-1], (2.0 * up - upper)[::-1]]], axis=1)
    _shape(axes, drawing, "wing", outline.T)
    depth = _DEPTH * drawing.chord_m
    _shape(axes, drawing, "pod", _ellipse(0.0, 0.0, depth, depth), paper())
    if drawing.dihedral_deg:
        angle = f"{given(drawing.dihedral_deg)}°"
        note(axes, angle, (half, float(up[-1])), (5, 0), ha="left", va="center")


def _draw_left(axes: Axes, drawing: Drawing, room_m: float) -> None:
    """Draw the view from the left: aft of the leading edge of the root, and up."""
    tail, chord, end = drawing.tail, drawing.chord_m, drawing.tail_end_m
    low, high = _fin_heights(drawing)
    root, boom = tail.boom_height_m, drawing.boom_m / 2.0
    _shape(axes, drawing, "tail", box(0.0, end, root - boom, root + boom), paper())
    pod = _ellipse((_POD / 2.0 - _NOSE) * chord, 0.0, _POD * chord, _DEPTH * chord)
    _shape(axes, drawing, "pod", pod, paper())
    fin_rear = tail.vertical_aft_m + tail.vertical_chord_m
    _shape(axes, drawing, "tail", box(tail.vertical_aft_m, fin_rear, low, high))
    plane = tail.horizontal_chord_m * _section(drawing.thickness_ratio)
    _shape(axes, drawing, "tail", plane + np.array([tail.horizontal_aft_m, tail.height_m]))
    section = _section(drawing.thickness_ratio, drawing.incidence_deg)
    for y in (drawing.wingspan_m / 2.0, 0.0) if drawing.dihedral_deg else (0.0,):
        edge = np.array([drawing.front_at(y), drawing.height_m(y)])
        points = drawing.chord_at(y) * section + edge
        _shape(axes, drawing, "section", points, "none" if y else GREY)
    _dimension(axes, end + room_m / 2.0, low, 0.0, high - low)
    _dimension(axes, 0.0, _heights(drawing)[0] - room_m, end, 0.0)
