"""Scale of season maps: colours in equal steps, the same in figures and pages."""

import numpy as np
import pytest

import missions
import sizing
import studies
from studies.case import Case
from studies.cli.files import opened
from studies.explorer.session import Session
from studies.output.season_scale import LEVELS_H, UNLIMITED_H, colours


def lab_of_srgb(rgb):
    """CIE L*a*b* of colours of a screen: IEC 61966-2-1 and CIE 15, the other way round."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz_of_rgb = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    t = linear @ xyz_of_rgb.T / np.array([0.95047, 1.0, 1.08883])
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack(
        [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1
    )


def test_steps_of_the_colours_look_equal():
    assert tuple(-level for level in reversed(LEVELS_H)) == LEVELS_H
    assert 0.0 in LEVELS_H
    assert max(LEVELS_H) < UNLIMITED_H
    lab = lab_of_srgb(colours()[:-1])
    each = (len(LEVELS_H) + 1) // 2
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    for arm in (steps[: each - 1], steps[each:]):
        # Matrices of four digits, and the gamut of a screen at the darkest purple.
        assert arm == pytest.approx(np.full(len(arm), arm.mean()), rel=0.05)
    assert lab[0, 0] == pytest.approx(lab[-1, 0], abs=0.5)
    assert lab[each - 1 : each + 1, 0].min() > 85.0
    # A day without a night is darker than all others.
    assert lab_of_srgb(colours())[-1, 0] < lab[:, 0].min() - 15.0


def test_figures_and_pages_have_the_same_scale():
    aircraft = sizing.load_aircraft("atlantiksolar-as2")
    mission = missions.load_mission("rafz-july")
    grid = {"latitudes": np.arange(-90.0, 91.0, 10.0), "days": np.arange(1, 366, 28)}
    figure = studies.plot_map(studies.feasibility_map(aircraft, mission, **grid))
    shades = next(one for one in figure.axes[0].collections if getattr(one, "filled", False))
    files = (opened("aircraft", aircraft.name), opened("mission", mission.name))
    session = Session(Case(*files))
    scale = session.describe()["season_scale"]
    assert shades.levels.tolist() == [*scale["levels_h"], scale["unlimited_h"]]
    middles = np.array([-20.0, -10.5, -7.5, -4.5, -1.5, 1.5, 4.5, 7.5, 10.5, 18.0, 48.0])
    drawn = np.round(255.0 * shades.cmap(shades.norm(middles))[:, :3]).astype(int)
    assert drawn.tolist() == scale["colours"]
