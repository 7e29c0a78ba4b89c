"""What the figures of a cycle and of a flight that ends show."""

import re

import numpy as np
import pytest
from figure_checks import heading, text_faults

import missions
import sizing
import studies
from studies.output.figures.options import FigureOptions

JULY = missions.load_mission("rafz-july")


def flown(*overrides):
    return sizing.analyse(sizing.load_aircraft("atlantiksolar-as2", overrides), JULY)


def test_excess_time_is_an_interval_that_begins_at_equal_power():
    analysis = flown()
    charge = studies.plot_cycle(analysis).axes[1]
    dawn_h = float(analysis.performance.cycle.equal_power_morning_h[0])
    (reserve,) = (
        line for line in charge.lines if line.get_linestyle() == ":" and line.get_ydata()[1] < 1
    )
    times, left = reserve.get_data()
    assert list(times) == pytest.approx([dawn_h, dawn_h + analysis.excess_time_h])
    assert left[1] == pytest.approx(0.0, abs=1e-9)
    texts = [text.get_text() for text in charge.texts]
    assert f"excess time {analysis.excess_time_h:.1f} h" in texts


def test_an_aircraft_that_comes_down_is_drawn_from_launch_to_empty():
    analysis = flown("power.avionics_w=60")
    hours = analysis.endurance_h
    figure = studies.plot_cycle(analysis)
    assert figure.get_suptitle().endswith(f"limited, {hours:.1f} h")
    power, charge = figure.axes
    clock_h, percent = charge.lines[0].get_data()
    assert (clock_h[0], percent[0]) == (analysis.best_launch_h, 100.0)
    assert clock_h[-1] == pytest.approx(clock_h[0] + hours)
    labels = [label.get_text() for label in charge.get_xticklabels()]
    assert next(label for label in labels if label.startswith("00:00")) == "00:00\nday 2"
    assert all(re.fullmatch(r"\d\d:00(\nday \d+)?", label) for label in labels)
    (least, most) = (charge.collections[0].get_paths()[0].vertices[:, 1].min(), 100.0)
    assert 0.0 <= least < most
    assert percent[-1] == pytest.approx(0.0, abs=0.05)  # the search ends within seconds
    assert np.min(percent[:-1]) >= 0.0
    assert power.get_ylabel() == "power [W]"


def test_a_flight_with_climbs_that_ends_is_drawn_with_its_altitude():
    analysis = sizing.analyse(
        sizing.load_aircraft("atlantiksolar-as2"),
        missions.load_mission("rafz-july", ["dates={on: 12-21}", "climb.ceiling_m=3536"]),
    )
    figure = studies.plot_cycle(analysis)
    assert figure.get_suptitle().endswith(f"limited, {analysis.endurance_h:.1f} h")
    _, charge, altitude = figure.axes
    clock_h, altitude_m = altitude.lines[0].get_data()
    assert clock_h[-1] - clock_h[0] == pytest.approx(analysis.endurance_h)
    assert len(charge.lines[0].get_xdata()) == len(clock_h)
    # From the floor of 536 m up and down again, to where the battery is empty.
    assert altitude_m[0] == pytest.approx(536.0)
    assert 536.0 - 1e-3 <= altitude_m[-1] < altitude_m.max()
    assert altitude_m.max() > 2500.0
    assert "highest altitude, repeated day" in str(analysis)


def test_notes_stand_below_the_title_and_go_with_it():
    analysis = flown()
    figure = studies.plot_cycle(analysis)
    assert heading(figure).endswith("\nCAM, uncorrected")
    figure.draw_without_rendering()
    (title,), (notes,) = figure.texts, figure.subfigs[0].texts
    assert notes.get_fontsize() < title.get_fontsize()
    assert notes.get_window_extent().y1 <= title.get_window_extent().y0
    bare = studies.plot_cycle(analysis, figure=FigureOptions(title=False))
    assert heading(bare) == "\n"


def test_a_small_figure_keeps_its_axes_and_its_texts():
    analysis = flown("modules.area_m2=0.68")
    # Full late: its text has little room to the right.
    assert 0.0 < analysis.performance.cycle.charge_margin_h[0] < 2.0
    small = FigureOptions(size_in=(3.35, 3.0), style="paper", title=False)
    figure = studies.plot_cycle(analysis, figure=small)
    assert not [fault for fault in text_faults(figure) if "leaves" in fault or "crosses" in fault]
    assert all(axes.get_position().height > 0.15 for axes in figure.axes)
