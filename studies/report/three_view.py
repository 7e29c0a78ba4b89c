"""Three views of an aircraft to scale: from above, from ahead, from the left."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from studies.report.geometry import Drawing
from studies.report.svg import Canvas, Point

_MARGIN, _TOP, _GAP, _LABEL = 14.0, 40.0, 30.0, 24.0
_ROOM_RIGHT = 74.0  # for the dimension of the chord
# Thickness of a symmetrical four-digit section over its chord, at full thickness ratio one
# (Abbott & von Doenhoff, Theory of Wing Sections, section 6.4).
_SECTION = (1.4845, -0.63, -1.758, 1.4215, -0.5075)
_STATIONS = 24
_MARK = 6.0  # radius of a point of balance [px]
_ROOM_FOR_LEGEND = 150.0  # beside the view from the left, else it stands below [px]
_ROOM_FOR_HALF = 80.0  # of the scale bar, for a number at its middle [px]


@dataclass(frozen=True)
class _View:
    """Places of a view in pixels: where its origin lies, and pixels per metre."""

    x: float
    y: float
    scale: float

    def at(self, right_m: float, down_m: float) -> Point:
        return self.x + self.scale * right_m, self.y + self.scale * down_m

    def box(self, left_m: float, right_m: float, top_m: float, bottom_m: float) -> list[Point]:
        corners = (
            (left_m, top_m), (right_m, top_m), (right_m, bottom_m), (left_m, bottom_m),
        )  # fmt: skip
        return [self.at(*corner) for corner in corners]


def three_view(
    drawing: Drawing,
    *,
    name: str,
    key: str,
    width: float,
    kind: str,
    gravity_m: float | None = None,
    neutral_m: float | None = None,
) -> str:
    """Three views with dimensions and a scale bar, as SVG.

    ``width``: width of the drawing [px]; texts keep their size. ``gravity_m``, ``neutral_m``:
    centre of gravity and neutral point behind the leading edge of the wing root, where known [m].
    """
    canvas = Canvas(width)
    ahead = max(drawing.nose_m, 0.0)
    room = width - _MARGIN - _ROOM_RIGHT
    scale = room / max(drawing.wingspan_m, ahead + drawing.tail_end_m)
    middle = _MARGIN + 0.5 * room
    above = _View(middle, _TOP + _LABEL + scale * ahead, scale)
    _draw_above(canvas, drawing, above)
    points = {"neutral point": neutral_m, "centre of gravity": gravity_m}
    known = {name: place for name, place in points.items() if place is not None}
    for point, place in known.items():
        _balance_mark(canvas, above.at(0.0, place), filled=point == "centre of gravity")
    bottom = above.y + scale * drawing.tail_end_m
    tip_m = drawing.height_m(drawing.wingspan_m / 2.0)
    highest = max(tip_m, *_tail_heights(drawing))
    lowest = max(drawing.pod_depth_m / 2.0, -min(_tail_heights(drawing)))
    front = _View(middle, bottom + _GAP + _LABEL + scale * highest, scale)
    _draw_ahead(canvas, drawing, front)
    bottom = front.y + scale * lowest
    side = _View(
        _MARGIN + scale * ahead,
        bottom + _GAP + _LABEL + scale * max(*_tail_heights(drawing), drawing.pod_depth_m / 2.0),
        scale,
    )
    _draw_side(canvas, drawing, side)
    canvas.text((_MARGIN, 16.0), "From above", "view", anchor="start")
    for text, y in (
        ("From ahead", front.y - scale * highest),
        ("From the left", bottom + _GAP + _LABEL),
    ):
        canvas.text((_MARGIN, y - 12.0), text, "view", anchor="start")
    end = side.y + scale * lowest + 34.0
    legend = (side.x + scale * drawing.tail_end_m + 96.0, bottom + _GAP + _LABEL)
    if width - legend[0] < _ROOM_FOR_LEGEND:
        legend = (_MARGIN, end + 8.0)
    x, lowest_y = legend[0], _draw_legend(canvas, drawing, legend, scale)
    for number, point in enumerate(known, 1):
        y = lowest_y + 19.0 * number
        _balance_mark(canvas, (x + 11.0, y - 5.0), filled=point == "centre of gravity")
        canvas.text((x + 30.0, y - 0.5), point, "label", anchor="start")
    end = max(end, lowest_y + 19.0 * len(known))
    canvas.height = math.ceil(end + 6.0)
    return canvas.markup(
        title=f"Three views of {name}",
        description=_described(drawing)
        + "".join(
            f" The {point} lies {place:.3f} m behind the leading edge of the wing root."
            for point, place in known.items()
        ),
        key=key,
        classes=("drawing", kind),
    )


def _balance_mark(canvas: Canvas, place: Point, *, filled: bool) -> None:
    """Point of balance: a circle, with two dark quarters for the centre of gravity."""
    x, y = place

    def arc(first: float, last: float) -> list[Point]:
        angles = [first + (last - first) * i / 16.0 for i in range(17)]
        return [(x + _MARK * math.cos(a), y + _MARK * math.sin(a)) for a in angles]

    canvas.shape(arc(0.0, 2.0 * math.pi), "point")
    for quarter in (0.0, math.pi) if filled else ():
        canvas.shape([(x, y), *arc(quarter, quarter + math.pi / 2.0)], "point dark")


def _described(drawing: Drawing) -> str:
    """What the drawing shows, for those who do not see it."""
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
    )


def _looks(drawing: Drawing, part: str, kind: str) -> str:
    return f"{kind} schematic" if part in drawing.schematic else kind


def _tail_heights(drawing: Drawing) -> tuple[float, float, float]:
    tail = drawing.tail
    return tail.boom_height_m, tail.boom_height_m + tail.vertical_height_m, tail.height_m


# ---- From above


def _draw_above(canvas: Canvas, drawing: Drawing, view: _View) -> None:
    tail, half = drawing.tail, drawing.wingspan_m / 2.0
    looks = _looks(drawing, "tail", "tail")
    pod, boom = drawing.pod_depth_m / 2.0, drawing.boom_m / 2.0
    for place in drawing.booms_m:
        tube = view.box(place - boom, place + boom, 0.0, drawing.tail_end_m)
        canvas.shape(tube, _looks(drawing, "tail", "body"))
    canvas.shape(_pod(view, drawing, pod), "body schematic")
    side = tail.horizontal_span_m / 2.0
    rear = tail.horizontal_aft_m + tail.horizontal_chord_m
    canvas.shape(view.box(-side, side, tail.horizontal_aft_m, rear), looks)
    for place in drawing.booms_m:
        canvas.line(
            view.at(place, tail.vertical_aft_m),
            view.at(place, tail.vertical_aft_m + tail.vertical_chord_m),
            "fin",
        )
    leading = [view.at(y, front) for y, front, _ in drawing.outline]
    trailing = [view.at(y, rear) for y, _, rear in reversed(drawing.outline)]
    canvas.shape([*leading, *trailing], "wing")
    for m in drawing.modules:
        canvas.shape(
            view.box(m.left_m, m.right_m, m.front_m, m.rear_m), _looks(drawing, "modules", "module")
        )
    canvas.line(
        view.at(-half, drawing.spar_m),
        view.at(half, drawing.spar_m),
        _looks(drawing, "spar", "spar"),
    )
    if drawing.dihedral_deg:
        for place in (-drawing.dihedral_from_m, drawing.dihedral_from_m):
            canvas.line(view.at(place, 0.0), view.at(place, drawing.chord_m), "break")
    canvas.line((view.x, view.at(0, -drawing.nose_m)[1] - 6.0),
                (view.x, view.at(0, drawing.tail_end_m)[1] + 8.0), "centre")  # fmt: skip
    _dimensions_above(canvas, drawing, view)


def _pod(view: _View, drawing: Drawing, half_width: float) -> list[Point]:
    """Outline of the pod, an ellipse from the nose on."""
    middle = drawing.pod_m / 2.0 - drawing.nose_m
    angles = [2.0 * math.pi * i / 40 for i in range(40)]
    return [
        view.at(half_width * math.sin(a), middle - drawing.pod_m / 2.0 * math.cos(a))
        for a in angles
    ]


def _dimensions_above(canvas: Canvas, drawing: Drawing, view: _View) -> None:
    tail, half = drawing.tail, drawing.wingspan_m / 2.0
    over = min(view.at(0.0, -drawing.nose_m)[1] - 22.0, view.y - 26.0)
    left, right = view.at(-half, 0.0), view.at(half, 0.0)
    for place in (left, right):
        canvas.line((place[0], place[1] - 4.0), (place[0], over - 4.0), "extension")
    canvas.dimension((left[0], over), (right[0], over), f"{drawing.wingspan_m:.2f} m")
    beside = right[0] + 14.0
    tip_m, front_m = drawing.chord_at(half), drawing.front_at(half)
    top, bottom = view.at(half, front_m)[1], view.at(half, front_m + tip_m)[1]
    for y in (top, bottom):
        canvas.line((right[0] + 3.0, y), (beside + 4.0, y), "extension")
    canvas.dimension((beside, top), (beside, bottom), f"{tip_m:.3f} m")
    side = tail.horizontal_span_m / 2.0
    rear = view.at(0.0, tail.horizontal_aft_m + tail.horizontal_chord_m)[1]
    arm_x = view.at(side, 0.0)[0] + 22.0
    fore = view.at(0.0, tail.horizontal_aft_m)[1]
    canvas.line((view.at(side, 0.0)[0] + 3.0, fore), (arm_x + 4.0, fore), "extension")
    canvas.dimension((arm_x, view.y), (arm_x, fore), f"{tail.horizontal_aft_m:.2f} m")
    canvas.text(
        (view.at(-side, 0.0)[0] - 8.0, (fore + rear) / 2.0 + 4.0),
        f"{tail.horizontal_span_m:.2f} × {tail.horizontal_chord_m:.2f} m",
        "value",
        anchor="end",
    )


# ---- From ahead


def _draw_ahead(canvas: Canvas, drawing: Drawing, view: _View) -> None:
    tail, half = drawing.tail, drawing.wingspan_m / 2.0
    inner = [y for y, _ in drawing.chords[1:-1]]
    right = sorted([drawing.dihedral_from_m, *inner, half])
    places = [*(-y for y in reversed(right)), *right]
    thick = {y: drawing.thickness_ratio * drawing.chord_at(y) / 2.0 for y in places}
    upper = [view.at(y, -drawing.height_m(y) - thick[y]) for y in places]
    lower = [view.at(y, -drawing.height_m(y) + thick[y]) for y in reversed(places)]
    fin = drawing.thickness_ratio * tail.vertical_chord_m / 2.0
    root, end, top = _tail_heights(drawing)
    looks = _looks(drawing, "tail", "tail")
    for y in drawing.booms_m:
        canvas.shape(view.box(y - fin, y + fin, -max(root, end), -min(root, end)), looks)
    plane = drawing.thickness_ratio * tail.horizontal_chord_m / 2.0
    side = tail.horizontal_span_m / 2.0
    canvas.shape(view.box(-side, side, -top - plane, -top + plane), looks)
    canvas.shape([*upper, *lower], "wing")
    radius = drawing.pod_depth_m / 2.0
    angles = [2.0 * math.pi * i / 32 for i in range(32)]
    canvas.shape(
        [view.at(radius * math.cos(a), radius * math.sin(a)) for a in angles], "body schematic"
    )
    if drawing.dihedral_deg:
        place = view.at(half, -drawing.height_m(half))
        canvas.text((place[0] + 8.0, place[1] + 4.0), f"{drawing.dihedral_deg:g}°", "value",
                    anchor="start")  # fmt: skip


# ---- From the left


def _draw_side(canvas: Canvas, drawing: Drawing, view: _View) -> None:
    tail = drawing.tail
    root, end, top = _tail_heights(drawing)
    looks = _looks(drawing, "tail", "tail")
    boom = drawing.boom_m / 2.0
    canvas.shape(
        view.box(0.0, drawing.tail_end_m, -root - boom, -root + boom),
        _looks(drawing, "tail", "body"),
    )
    canvas.shape(_pod_from_left(view, drawing), "body schematic")
    fin_rear = tail.vertical_aft_m + tail.vertical_chord_m
    canvas.shape(view.box(tail.vertical_aft_m, fin_rear, -max(root, end), -min(root, end)), looks)
    section = _section(drawing.thickness_ratio)
    canvas.shape(
        [
            view.at(tail.horizontal_aft_m + tail.horizontal_chord_m * x,
                    -top - tail.horizontal_chord_m * z)
            for x, z in section
        ],
        looks,
    )  # fmt: skip
    tip_m = drawing.height_m(drawing.wingspan_m / 2.0)
    if tip_m:
        canvas.shape(_wing_section(view, drawing, drawing.wingspan_m / 2.0), "wing tip")
    canvas.shape(_wing_section(view, drawing, 0.0), _looks(drawing, "section", "wing"))
    right = view.at(max(fin_rear, drawing.tail_end_m), 0.0)[0] + 14.0
    heights = sorted((view.at(0.0, -root)[1], view.at(0.0, -end)[1]))
    for y in heights:
        canvas.line((view.at(fin_rear, 0.0)[0] + 3.0, y), (right + 4.0, y), "extension")
    canvas.dimension((right, heights[0]), (right, heights[1]), f"{abs(end - root):.2f} m")
    under = view.y + view.scale * max(drawing.pod_depth_m / 2.0, -min(root, end)) + 20.0
    start, stop = view.at(0.0, 0.0), view.at(drawing.tail_end_m, 0.0)
    for place in (start, stop):
        canvas.line((place[0], under - 8.0), (place[0], under + 4.0), "extension")
    canvas.dimension((start[0], under), (stop[0], under), f"{drawing.tail_end_m:.2f} m")


def _pod_from_left(view: _View, drawing: Drawing) -> list[Point]:
    middle = drawing.pod_m / 2.0 - drawing.nose_m
    angles = [2.0 * math.pi * i / 40 for i in range(40)]
    return [
        view.at(middle + drawing.pod_m / 2.0 * math.cos(a), drawing.pod_depth_m / 2.0 * math.sin(a))
        for a in angles
    ]


def _section(thickness_ratio: float) -> list[Point]:
    """Outline of a symmetrical section of chord one, aft and up."""
    chords = [0.5 * (1.0 - math.cos(math.pi * i / _STATIONS)) for i in range(_STATIONS + 1)]
    upper = [(x, thickness_ratio * _half_thickness(x)) for x in chords]
    return [*upper, *((x, -z) for x, z in reversed(upper[1:-1]))]


def _half_thickness(x: float) -> float:
    root, *powers = _SECTION
    return float(root * x**0.5 + sum(a * x ** (i + 1) for i, a in enumerate(powers)))


def _wing_section(view: _View, drawing: Drawing, right_m: float) -> list[Point]:
    """Section of the wing at its incidence, nose up about the leading edge."""
    height_m, front_m = drawing.height_m(right_m), drawing.front_at(right_m)
    chord_m, pitch = drawing.chord_at(right_m), math.radians(drawing.incidence_deg)
    turned = (
        (x * math.cos(pitch) + z * math.sin(pitch), -x * math.sin(pitch) + z * math.cos(pitch))
        for x, z in _section(drawing.thickness_ratio)
    )
    return [view.at(front_m + chord_m * x, -chord_m * z - height_m) for x, z in turned]


# ---- Legend and scale


def _draw_legend(canvas: Canvas, drawing: Drawing, place: Point, scale: float) -> float:
    """Scale bar and what the looks mean; returns the lowest place."""
    x, y = place
    bar_m = _round_length(0.3 * (canvas.width - x - _MARGIN) / scale, drawing.wingspan_m)
    for i in range(2):
        kind = "scale dark" if i == 0 else "scale"
        start, end = x + scale * bar_m * i / 2.0, x + scale * bar_m * (i + 1) / 2.0
        canvas.shape([(start, y), (end, y), (end, y + 6.0), (start, y + 6.0)], kind)
    for share in (0.0, 0.5, 1.0) if scale * bar_m > _ROOM_FOR_HALF else (0.0, 1.0):
        text = f"{bar_m * share:g}" + (" m" if share == 1.0 else "")
        canvas.text((x + scale * bar_m * share, y + 20.0), text, "value")
    y += 42.0
    for kind, text in _legend(drawing):
        canvas.shape([(x, y - 9.0), (x + 22.0, y - 9.0), (x + 22.0, y), (x, y)], kind)
        canvas.text((x + 30.0, y - 0.5), text, "label", anchor="start")
        y += 19.0
    canvas.line((x, y - 5.0), (x + 22.0, y - 5.0), _looks(drawing, "spar", "spar"))
    canvas.text((x + 30.0, y - 0.5), "spar", "label", anchor="start")
    return y


def _legend(drawing: Drawing) -> Iterable[tuple[str, str]]:
    if drawing.modules:
        yield _looks(drawing, "modules", "module"), "solar modules"
    yield "body schematic", "schematic"


def _round_length(longest_m: float, span_m: float) -> float:
    """Length of the scale bar: 1, 2 or 5 times a power of ten, no longer than fits."""
    longest_m = min(longest_m, 0.3 * span_m)
    power: float = 10.0 ** math.floor(math.log10(longest_m))
    return float(next(power * step for step in (5.0, 2.0, 1.0) if power * step <= longest_m))
