"""A figure in a style, with a layout in which every text has its place whatever its size.

Matplotlib's constrained layout makes room for axes; it leaves labels that are longer than their
axis, ticks that run into each other, legends wider than the page. Those are wrapped, thinned and
reflowed here, each time anew, so that a figure may be resized.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from matplotlib.offsetbox import VPacker
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FuncFormatter
from matplotlib.transforms import Bbox

from studies.output.figures import options as settings
from studies.output.figures.options import LEVELS, NAMES, ROWS, FigureOptions

_ROUNDS = 3
_LEAST_TYPE = 0.5  # of the size that a style asks for
_HIGHEST_LEGEND = 0.28  # of the figure: what is higher gets smaller type, for more columns
_LEGEND_TYPES = (1.0, 0.9, 0.8, 0.7)  # of the size of a legend's type
_GAP = 0.25  # between texts, in sizes of type
_WIDEST_NAMES = 0.42  # of the figure
_STEPS = (0.0, 0.7, -0.7, 1.4, -1.4, 2.1, -2.1, 2.8, -2.8)  # heights of a text that it is moved by


class FittedLayout(ConstrainedLayoutEngine):
    """Constrained layout, with a heading in two sizes and texts that fit.

    ``notes``: line below the title, in smaller type; left out where the title is taken away.
    ``collapsed``: whether the figure was too small for its axes when it was laid out last.
    """

    def __init__(self) -> None:
        super().__init__()
        self.notes = ""
        self.collapsed = False
        self._below: Text | None = None
        self._undo: list[Callable[[], None]] = []
        self._thinned: dict[Axis, list[Text]] = {}

    def execute(self, fig: Figure) -> Any:
        """Lay a figure out."""
        for restore in reversed(self._undo):
            restore()
        self._undo.clear()
        self.set(rect=(0.0, 0.0, 1.0, 1.0 - self._draw_heading(fig)))
        # What leaves no room for axes at all, before they are asked how large they are.
        self._fit_legends(fig)
        for axes in fig.axes:
            self._break_names(axes.yaxis)
        done = self._constrained(fig)
        for _ in range(_ROUNDS):
            changed = [self._fit_legends(fig), *(self._fit_axes(axes) for axes in fig.axes)]
            if not any(changed):
                break
            done = self._constrained(fig)
        for axes in fig.axes:
            for axis in (axes.xaxis, axes.yaxis):
                self._fit_ticks(axis)
            self._clear_corner(axes)
            self._fit_notes(axes)
        return done

    def _constrained(self, fig: Figure) -> Any:
        """Constrained layout; where it gives up, that is noted and not warned of."""
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            done = super().execute(fig)
        self.collapsed = any("collapsed" in str(one.message) for one in told)
        for one in told:
            if "collapsed" not in str(one.message):
                warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
        return done

    def _set(self, artist: Text, /, **looks: Any) -> None:
        """Change a text until the next layout."""
        before = {name: getattr(artist, f"get_{name}")() for name in looks}
        self._undo.append(lambda: _restore(artist, before, looks))
        artist.set(**looks)

    # ---- Title and the notes below it

    def _draw_heading(self, fig: Figure) -> float:
        """Write title and notes; their share of the figure's height."""
        title = fig._suptitle  # type: ignore[attr-defined]  # as constrained layout does
        if self._below is not None:
            self._below.set_visible(False)
        if title is None or not title.get_text():
            return 0.0
        title.set_in_layout(False)
        pad = 0.3 * title.get_fontsize() * fig.dpi / 72.0
        room = fig.bbox.width - 2.0 * pad
        self._set(title, text=_wrapped(title, title.get_text(), room))
        high = title.get_window_extent().height + 2.0 * pad
        title.set(y=1.0 - pad / fig.bbox.height, va="top")
        if self.notes:
            if self._below is None:
                size = title.get_fontsize() * 0.8
                self._below = fig.text(0.5, 0.0, "", ha="center", va="top", fontsize=size)
                self._below.set_in_layout(False)
            self._below.set(visible=True, text="")
            self._below.set_text(_wrapped(self._below, self.notes, room))
            self._below.set_y(1.0 - high / fig.bbox.height)
            high += self._below.get_window_extent().height + pad
        return float(high / fig.bbox.height)

    # ---- Legends

    def _fit_legends(self, fig: Figure) -> bool:
        changed = False
        for legend, room in _legends(fig):
            if legend.get_window_extent().width <= room:
                continue
            changed |= self._reflow(legend, room)
        return changed

    def _reflow(self, legend: Legend, room: float) -> bool:
        """Fewer columns, in smaller type where high; then broken labels, then smaller type."""
        columns = _legend_columns(legend)
        items = [item for column in columns for item in column.get_children()]
        before = list(columns)
        figure = legend.get_figure()
        assert figure is not None
        most = _HIGHEST_LEGEND * figure.bbox.height
        sizes = [float(text.get_fontsize()) for text in legend.get_texts()]
        for scale in _LEGEND_TYPES:
            if scale < 1.0:
                for text, size in zip(legend.get_texts(), sizes, strict=True):
                    self._set(text, fontsize=max(scale * size, _LEAST_TYPE * 10.0))
            for count in range(len(before), 0, -1):
                _arrange(legend, items, count)
                if legend.get_window_extent().width <= room:
                    break
            if len(before) == 1 or legend.get_window_extent().height <= most:
                break
        changed = len(before) > 1
        if changed:
            self._undo.append(lambda: _set_columns(legend, before))
        wide = legend.get_window_extent().width
        if wide <= room:
            return changed
        for text in legend.get_texts():
            own = text.get_window_extent().width
            wrapped = _wrapped(text, text.get_text(), own - (wide - room))
            if wrapped != text.get_text():
                self._set(text, text=wrapped)
                changed = True
        wide = legend.get_window_extent().width
        size = float(legend.get_texts()[0].get_fontsize()) if legend.get_texts() else 0.0
        if wide > room and size > _LEAST_TYPE * 10.0:
            for text in legend.get_texts():
                self._set(text, fontsize=max(size * room / wide, _LEAST_TYPE * 10.0))
            changed = True
        return changed

    # ---- Axes

    def _fit_axes(self, axes: Axes) -> bool:
        box = axes.get_window_extent()
        changed = False
        for axis, room in ((axes.xaxis, box.width), (axes.yaxis, box.height)):
            changed |= self._fit_text(axis.label, room)
            changed |= self._fit_ticks(axis)
        for title in (axes.title, axes._left_title, axes._right_title):  # type: ignore[attr-defined]
            changed |= self._fit_text(title, box.width)
        return changed

    def _clear_corner(self, axes: Axes) -> None:
        """Leave out the lowest label of the vertical axis where the first of the other meets it."""
        across = [t.get_window_extent() for t in _drawn_ticks(axes.xaxis)]
        for label in _drawn_ticks(axes.yaxis):
            box = label.get_window_extent()
            if axes.yaxis.get_gid() != NAMES and any(box.overlaps(other) for other in across):
                label.set_visible(False)
                self._thinned.setdefault(axes.yaxis, []).append(label)

    def _fit_text(self, text: Text, room: float) -> bool:
        if not text.get_visible() or not text.get_text():
            return False
        extent = text.get_window_extent()
        if max(extent.width, extent.height) <= room:
            return False
        wrapped = _wrapped(text, text.get_text(), room)
        if wrapped == text.get_text():
            return False
        self._set(text, text=wrapped)
        return True

    def _fit_ticks(self, axis: Axis) -> bool:
        thinned = self._thinned.pop(axis, [])
        before = len(thinned)
        for label in thinned:
            label.set_visible(True)
        labels = _drawn_ticks(axis)
        if axis.get_gid() == NAMES:
            return self._fit_names(axis, labels)
        along = 0 if axis.axis_name == "x" else 1  # type: ignore[attr-defined]
        labels = [label for label in labels if label.get_visible()]
        boxes = [label.get_window_extent() for label in labels]
        order = sorted(range(len(labels)), key=lambda i: boxes[i].min[along])
        for stride in range(1, len(order)):
            kept = order[::stride]
            if all(
                boxes[b].min[along] - boxes[a].max[along] > _GAP * float(labels[a].get_fontsize())
                for a, b in itertools.pairwise(kept)
            ):
                break
        else:
            kept = order[:1]
        hidden = [labels[index] for index in set(order) - set(kept)]
        for label in hidden:
            label.set_visible(False)
        self._thinned[axis] = hidden
        return len(hidden) != before

    def _break_names(self, axis: Axis) -> None:
        """Break names beside an axis into lines, so that they leave room for the axes."""
        figure, spec = axis.get_figure(), axis.axes.get_subplotspec()
        if axis.get_gid() != NAMES or figure is None:
            return
        panels = 1 if spec is None else spec.get_gridspec().ncols
        room = _WIDEST_NAMES * figure.bbox.width / panels**0.6
        before, labels = axis.get_major_formatter(), _drawn_ticks(axis)
        if labels:
            # The names are the formatter's, which writes them whenever ticks are drawn.
            places = list(axis.get_majorticklocs())
            names = before.format_ticks(places)
            broken = [_wrapped(labels[0], str(name), room) for name in names]
            by_place = dict(zip(places, broken, strict=True))
            axis.set_major_formatter(FuncFormatter(lambda place, _: by_place.get(place, "")))
            self._undo.append(lambda: axis.set_major_formatter(before))

    def _fit_names(self, axis: Axis, labels: list[Text]) -> bool:
        """Names along an axis in smaller type where they meet; none is left out."""
        changed = False
        along = 0 if axis.axis_name == "x" else 1  # type: ignore[attr-defined]
        size = float(labels[0].get_fontsize()) if labels else 0.0
        while size > _LEAST_TYPE * 10.0:
            boxes = sorted((t.get_window_extent() for t in labels), key=lambda b: b.min[along])
            if all(b.min[along] >= a.max[along] for a, b in itertools.pairwise(boxes)):
                break
            size *= 0.9
            for label in labels:
                self._set(label, fontsize=size)
            changed = True
        return changed

    def _fit_notes(self, axes: Axes) -> None:
        """Move what is written at points of the axes where it meets something else."""
        legend = axes.get_legend()
        taken = [] if legend is None else [legend.get_window_extent()]
        notes = [note for note in axes.texts if note.get_visible() and note.get_text()]
        frame = axes.get_window_extent()
        self._fit_rows([note for note in notes if note.get_gid() == ROWS])
        for note in notes:
            if note.get_gid() == LEVELS:
                self._keep_free(note, frame, taken)
            elif not (isinstance(note, Annotation) and note.anncoords == "offset points"):
                taken.append(Text.get_window_extent(note))
        for note in notes:
            if isinstance(note, Annotation) and note.anncoords == "offset points":
                taken.append(self._free_place(note, frame, taken))

    def _keep_free(self, label: Text, frame: Bbox, taken: list[Bbox]) -> None:
        """Leave out the label of a level that meets another, or the frame."""
        box = label.get_window_extent()
        within = frame.x0 < box.x0 and box.x1 < frame.x1 and frame.y0 < box.y0 < box.y1 < frame.y1
        if not within or any(box.padded(0.5 * box.height).overlaps(other) for other in taken):
            self._set(label, visible=False)
        else:
            taken.append(box)

    def _fit_rows(self, rows: list[Text]) -> None:
        """Write what stands in rows so small that the rows do not meet."""
        size = float(rows[0].get_fontsize()) if rows else 0.0
        while size > _LEAST_TYPE * 10.0:
            boxes = [Text.get_window_extent(row) for row in rows]
            if not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2)):
                break
            size *= 0.9
            for row in rows:
                self._set(row, fontsize=size)

    def _free_place(self, note: Annotation, frame: Bbox, taken: Sequence[Bbox]) -> Bbox:
        """Place of a note, near where it was, within the frame and off all others."""
        box = Text.get_window_extent(note)  # without an arrow
        shifts = itertools.product(_STEPS, (0.0, 0.5, -0.5, 1.0, -1.0))
        best = None
        for up, right in sorted(shifts, key=lambda s: abs(s[0]) + 2.0 * abs(s[1])):
            place = box.translated(right * box.width, up * box.height)
            place = place.translated(*_inwards(place, frame))
            if box.overlaps(frame) and not place.overlaps(frame):
                continue  # beside the axes it would run out of the figure
            if not any(place.overlaps(other) for other in taken):
                best = place
                break
        if best is None:
            best = box.translated(*_inwards(box, frame))
        figure = note.get_figure()
        assert figure is not None
        per_dot = 72.0 / figure.dpi
        shift = ((best.x0 - box.x0) * per_dot, (best.y0 - box.y0) * per_dot)
        if shift != (0.0, 0.0):
            before = note.xyann
            self._undo.append(lambda: setattr(note, "xyann", before))
            note.xyann = (before[0] + shift[0], before[1] + shift[1])
        return best


def _restore(artist: Text, before: dict[str, Any], looks: dict[str, Any]) -> None:
    """Undo changes of a text; what its owner has changed since is left."""
    for name, value in looks.items():
        if getattr(artist, f"get_{name}")() == value:
            artist.set(**{name: before[name]})


def _inwards(box: Bbox, frame: Bbox) -> tuple[float, float]:
    """Shift that brings a box into a frame; none where it is larger, or lies outside of it."""
    inwards = []
    for low, high, first, last in (
        (box.x0, box.x1, frame.x0, frame.x1),
        (box.y0, box.y1, frame.y0, frame.y1),
    ):
        outside = high <= first or low >= last or high - low > last - first
        inwards.append(
            0.0 if outside else max(first + 1.0 - low, 0.0) - max(high - last + 1.0, 0.0)
        )
    return inwards[0], inwards[1]


def _wrapped(text: Text, words: str, room: float) -> str:
    """Words in lines that are no longer than the room, as this text is drawn; at spaces only."""
    before, rotation = text.get_text(), text.get_rotation()
    text.set_rotation(0.0)

    def width(line: str) -> float:
        text.set_text(line)
        return float(text.get_window_extent().width)

    lines: list[str] = []
    for paragraph in words.split("\n"):
        line = ""
        for word in paragraph.split(" "):
            longer = f"{line} {word}" if line else word
            if line and width(longer) > room:
                lines.append(line)
                line = word
            else:
                line = longer
        lines.append(line)
    text.set_text(before)
    text.set_rotation(rotation)
    return "\n".join(line.removesuffix(" ·").removeprefix("· ") for line in lines)


def _drawn_ticks(axis: Axis) -> list[Text]:
    """Labels of the ticks that are within the axis."""
    ticks = axis._update_ticks()  # type: ignore[attr-defined]  # no public way to those drawn
    labels = [label for tick in ticks for label in (tick.label1, tick.label2)]
    return [label for label in labels if label.get_visible() and label.get_text()]


def _legends(fig: Figure) -> Iterator[tuple[Legend, float]]:
    for legend in fig.legends:
        yield legend, 0.99 * fig.bbox.width
    for axes in fig.axes:
        own = axes.get_legend()
        if own is None:
            continue
        within = own.get_bbox_to_anchor().width > 1.0
        yield own, axes.bbox.width if within else 0.4 * fig.bbox.width


def _legend_columns(legend: Legend) -> list[Any]:
    """Columns of a legend, the list that it draws."""
    box: Any = legend.get_children()[0]  # above it the title
    columns: list[Any] = box.get_children()[1].get_children()
    return columns


def _arrange(legend: Legend, items: Sequence[Any], count: int) -> None:
    """Put the entries of a legend into so many columns, as even as they go."""
    sizes = [len(items) // count + (index < len(items) % count) for index in range(count)]
    ends = list(itertools.accumulate(sizes))
    spacing = legend.labelspacing * legend._fontsize  # type: ignore[attr-defined]
    packed = [
        VPacker(pad=0, sep=spacing, align="baseline", children=list(items[end - size : end]))
        for size, end in zip(sizes, ends, strict=True)
    ]
    for column in packed:
        column.set_figure(legend.get_figure())  # type: ignore[arg-type]
    _set_columns(legend, packed)


def _set_columns(legend: Legend, columns: list[Any]) -> None:
    _legend_columns(legend)[:] = columns


class StyledFigure(Figure):
    """Figure in a style."""

    def __init__(self, options: FigureOptions, size_in: tuple[float, float]) -> None:
        super().__init__(figsize=size_in, layout=FittedLayout())
        self.options = options
        self.notes = ""

    def set_heading(self, title: str, notes: str) -> None:
        """Write a title, and notes below it in smaller type."""
        self.suptitle(title)
        self.notes = notes
        engine = self.get_layout_engine()
        assert isinstance(engine, FittedLayout)
        engine.notes = notes

    def draw(self, renderer: Any) -> None:
        """Draw the figure in its style: its layout writes texts anew, in a notebook as well."""
        with settings.in_style(self.options):
            layout = self.get_layout_engine()
            if isinstance(layout, FittedLayout) and self.canvas.is_saving():
                # Matplotlib draws twice to save: first for the layout alone, the strokes going
                # nowhere, then without a layout engine. The first time needs no strokes.
                layout.execute(self)
            else:
                super().draw(renderer)

    def savefig(self, fname: Any, **kwargs: Any) -> None:
        """Write the figure as :meth:`matplotlib.figure.Figure.savefig` does, in its style.

        ``**kwargs``: as there; the resolution is by default that of the options.
        """
        kwargs.setdefault("dpi", self.options.dots_per_inch or settings.DOTS_PER_INCH)
        with settings.in_style(self.options):
            super().savefig(fname, **kwargs)
