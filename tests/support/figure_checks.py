"""Every figure, made once, and what may be wrong with one: cut off texts, alike lines.

The figures are those of the shipped aircraft, on grids as coarse as a figure bears.
"""

import itertools
from contextlib import nullcontext
from functools import cache

import numpy as np
from builders import AS2, DESIGN, shipped_mission
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import Polygon
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from weather_files import clear_record

import missions
import sizing
import studies
from missions.logs.table import log_from_table
from studies.output.figures.options import in_style

# A little of what a glyph's box has around the glyph may meet another, or the edge [px].
_BLEED_PX = 1.0


# ---- Every figure


def drawings():
    """What draws each figure, by a name; it takes the keyword ``figure``."""
    from benchmarks.validation.structure_comparison import structure_figure
    from studies.flight_logs.plots import residual_figure, window_figure
    from studies.models.report_reproduction import reproduction_figure

    return {
        "cycle": lambda **kw: studies.plot_cycle(_flown(), **kw),
        "cycle-climbing": lambda **kw: studies.plot_cycle(_flown(keys=_CEILING), **kw),
        "cycle-climbing-short": lambda **kw: studies.plot_cycle(
            _flown(keys=f"dates={{on: 12-21}};{_CEILING}"), **kw
        ),
        "cycle-short": lambda **kw: studies.plot_cycle(
            _flown("rafz-july", "", "power.avionics_w=60"), **kw
        ),
        "flight": lambda **kw: studies.plot_flight(
            _flown("rafz-28h"), _flown("rafz-28h").flight, **kw
        ),
        "sensitivities": _sensitivities,
        "masses": lambda **kw: studies.plot_masses(
            _sized().result.design.masses._asdict(), "atlantiksolar-design: mass budget", **kw
        ),
        "map": lambda **kw: studies.plot_map(_map(), **kw),
        "resized-map": lambda **kw: studies.plot_resized_map(_resized_map(), **kw),
        "sweep-line": lambda **kw: studies.plot_sweep(_sweep(battery_mass_kg=_BATTERIES), **kw),
        "sweep-grid": lambda **kw: studies.plot_sweep(
            _sweep(wingspan_m=_SPANS, battery_mass_kg=_BATTERIES, aspect_ratio=(14.0, 18.5)), **kw
        ),
        "sweep-sample": lambda **kw: studies.plot_sweep(_sampled(), **kw),
        "sweep-one-at-a-time": lambda **kw: studies.plot_sweep(_one_at_a_time(), **kw),
        "pareto": lambda **kw: studies.plot_pareto(
            _sweep(wingspan_m=_SPANS, battery_mass_kg=_BATTERIES), "wingspan", "excess_time", **kw
        ),
        "uncertainty": lambda **kw: studies.plot_uncertainty(_uncertain(), **kw),
        "weather": lambda **kw: studies.plot_weather(_weather(40), **kw),
        "weather-years": lambda **kw: studies.plot_weather(_weather(800), **kw),
        "compare": lambda **kw: studies.plot_comparison(_compared(), **kw),
        "ceiling": lambda **kw: studies.plot_ceiling(_ceiling(), **kw),
        "verify-window": lambda **kw: window_figure(_verified(), 0, **kw),
        "verify-residuals": lambda **kw: residual_figure(_verified(), **kw),
        "structure": structure_figure,
        "power-curve": _power_curve,
        "report": lambda **kw: reproduction_figure(_reproduced(), **kw),
    }


_SPANS = tuple(np.arange(3.0, 7.1, 0.5))
_BATTERIES = tuple(np.arange(1.0, 10.1, 1.0))


@cache
def _flown(mission="rafz-july", keys="", *overrides):
    """Analysis of AtlantikSolar; keys of the mission are separated by semicolons."""
    aircraft = sizing.load_aircraft("atlantiksolar-as2", overrides)
    where = missions.load_mission(mission, [key for key in keys.split(";") if key])
    return sizing.analyse(aircraft, where)


_CEILING = "climb.ceiling_m=3000"


@cache
def _sized():
    options = {"required_excess_time_h": 2.0, "with_sensitivities": True}
    return sizing.size(DESIGN, shipped_mission(), "min_wingspan", **options)


def _sensitivities(figure):
    from studies.output.sizing_files import plot_sensitivities

    study = _sized()
    return plot_sensitivities(
        study.sensitivities,
        study.result.objective,
        study.aircraft.name,
        study.solar,
        extrapolations=study.extrapolations,
        figure=figure,
    )


@cache
def _map():
    latitudes, days = np.arange(-70.0, 71.0, 10.0), list(range(1, 366, 14))
    return studies.feasibility_map(AS2, shipped_mission(), latitudes=latitudes, days=days)


@cache
def _resized_map():
    return studies.resized_map(
        DESIGN,
        shipped_mission(),
        "min_wingspan",
        latitudes=np.arange(-70.0, 71.0, 14.0),
        days=list(range(1, 366, 28)),
        correction="report",
    )


@cache
def _sweep(**axes):
    where = shipped_mission("central-europe-summer")
    return studies.sweep(DESIGN, where, {key: list(values) for key, values in axes.items()})


@cache
def _sampled():
    ranges = {"wingspan_m": (3.0, 7.0), "battery_mass_kg": (1.0, 9.0), "power.avionics_w": (4, 9)}
    return studies.sweep(DESIGN, shipped_mission(), ranges, sample="lhs", samples=12)


@cache
def _one_at_a_time():
    values = {
        "battery.specific_energy_wh_per_kg": [230, 300],
        "wingspan_m": [4.0, 7.0],
        "modules.efficiency_stc": [0.2, 0.26],
    }
    return studies.sweep(DESIGN, shipped_mission(), values, sample="one-at-a-time")


@cache
def _uncertain():
    return sizing.analyse_uncertainty(DESIGN, shipped_mission(), samples=256)


@cache
def _weather(days):
    record = clear_record(days, first="2001-07-14", share=0.9 if days > 400 else 0.3)
    return sizing.analyse_weather(AS2, shipped_mission(), record)


@cache
def _compared():
    return studies.compare(DESIGN, shipped_mission(), required_excess_time_h=3.0)


@cache
def _ceiling():
    return studies.perpetual_ceiling(AS2, shipped_mission(), highest_m=9000.0, step_m=1000.0)


@cache
def _verified():
    from synthetic_logs import START_UTC_S, Faults, Settings, synthetic_log

    settings = Settings(
        start_utc_s=START_UTC_S + 18.3 * 3600.0,
        duration_h=8.0,
        rate_hz=0.1,
        faults=Faults(battery_full=(5.0, 6.0)),
    )
    log = synthetic_log(AS2, shipped_mission("rafz-28h"), settings)
    with_gap = log_from_table(log[(log.index < 700) | (log.index > 900)], "synthetic.csv")
    return studies.verify(AS2, with_gap, shipped_mission("rafz-28h"), windows=["5.0:7.0"])


def _power_curve(figure):
    from benchmarks.validation import power_curve

    checks = power_curve.check_level_flight()[:3]
    polars = [
        power_curve.wing_polar(c.airfoil, power_curve.AS1, calibration=c.calibration)
        for c in checks
    ]
    return power_curve.power_curve_figure(polars, figure=figure)


@cache
def _reproduced():
    from studies.models import report_reproduction as study

    return study.reproduce(AS2, shipped_mission("rafz-loiter"), vary=False)


# ---- What may be wrong


def text_faults(figure):
    """Texts of a drawn figure that leave it, cross the frame of axes, or meet each other."""
    # How many ticks there are depends on the type, which a figure has while it is drawn.
    options = getattr(figure, "options", None)
    with nullcontext() if options is None else in_style(options):
        return _text_faults(figure)


def _text_faults(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    texts = list(_drawn_texts(figure))
    corners = {text: _corners(text) for text in texts}
    faults = []
    width, height = figure.bbox.width, figure.bbox.height
    for text, at in corners.items():
        low, high = at.min(axis=0), at.max(axis=0)
        if low.min() < -_BLEED_PX or high[0] > width + _BLEED_PX or high[1] > height + _BLEED_PX:
            faults.append(f"{text.get_text()!r} leaves the figure")
    for one, other in itertools.combinations(texts, 2):
        if _overlap(corners[one], corners[other]):
            faults.append(f"{one.get_text()!r} meets {other.get_text()!r}")
    for axes in figure.axes:
        for text in axes.texts:
            if text in corners and _crosses_frame(axes, corners[text]):
                faults.append(f"{text.get_text()!r} crosses the frame of its axes")
    return faults


def _drawn_texts(figure):
    ticks = set()
    drawn = []
    for axis in figure.findobj(Axis):
        for tick in (*axis.majorTicks, *axis.minorTicks):
            ticks.update((tick.label1, tick.label2))
        if axis.get_visible() and axis.axes.axison and axis.axes in figure.axes:
            shown = axis._update_ticks()  # type: ignore[attr-defined]  # those within view
            drawn += [label for tick in shown for label in (tick.label1, tick.label2)]
    found = [text for text in figure.findobj(Text) if text not in ticks]
    for text in dict.fromkeys([*found, *drawn]):
        if text.get_visible() and text.get_text().strip():
            yield text


def _corners(text):
    """Corners of the box around a text, turned as the text is."""
    angle = text.get_rotation()
    outer = Text.get_window_extent(text)
    centre = np.array([(outer.x0 + outer.x1) / 2.0, (outer.y0 + outer.y1) / 2.0])
    text.set_rotation(0.0)
    box = Text.get_window_extent(text)
    text.set_rotation(angle)
    half = np.array([box.width, box.height]) / 2.0 - _BLEED_PX
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    turn = np.radians(angle)
    turned = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return np.asarray(square @ turned + centre)


def _overlap(one, other):
    """Whether two boxes, turned as their texts are, meet."""
    return Polygon(one).get_path().intersects_path(Polygon(other).get_path(), filled=True)


def _crosses_frame(axes, corners):
    frame, box = axes.get_window_extent(), Bbox([corners.min(axis=0), corners.max(axis=0)])
    within = all(frame.padded(1).contains(*corner) for corner in (box.min, box.max))
    return frame.fully_overlaps(box) and not within


def alike_lines(figure):
    """Pairs of named lines of one axes that only their colour tells apart."""
    found = []
    for axes in figure.axes:
        looks = {}
        for line in axes.lines:
            label = str(line.get_label())
            if label.startswith("_") or not len(line.get_xdata()):  # type: ignore[arg-type]
                continue
            look = (line._dash_pattern, line.get_marker(), line.get_linewidth())  # type: ignore[attr-defined]
            look = repr((look, line.get_fillstyle()))
            if look in looks:
                found.append(f"{label!r} looks like {looks[look]!r}")
            looks[look] = label
    return found


def heading(figure):
    """Title of a figure, and the notes below it in a line of their own."""
    below = figure.subfigs[0].get_suptitle() if figure.subfigs else ""
    return f"{figure.get_suptitle()}\n{below}"
