"""Cells of maps: colours in equal steps, reasons in words."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from sizing.parameters import label
from studies.output.cells import diverging, hatch_cells, requirement_label


def lab_of_srgb(rgb: np.ndarray) -> np.ndarray:
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


def test_steps_of_the_diverging_colours_look_equal() -> None:
    lab = lab_of_srgb(np.array(diverging().colors))
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    for arm in (steps[:126], steps[128:]):
        assert arm == pytest.approx(np.full(len(arm), arm.mean()), rel=0.05)  # rounded matrices
    assert lab[0, 0] == pytest.approx(lab[-1, 0], abs=0.5)
    assert lab[:, 0].max() > 95.0


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("sun", "polar night"),
        ("battery_capacity", "battery: does not last the night"),
        ("wing_loading_kg_per_m2_maximum", f"limit: {label('wing_loading_kg_per_m2')}"),
        ("", "no design"),
    ],
)
def test_requirements_are_told_in_words(name: str, words: str) -> None:
    assert requirement_label(name) == words


def test_all_cells_of_a_hatch_are_one_path() -> None:
    """Each of its own took 1.3 s for the nights of the whole earth."""
    x, y = np.array([1.0, 2.0, 4.0, 5.0]), np.array([-10.0, 0.0, 30.0])
    status = np.array([[1, 1, 0, 1], [0, 0, 0, 2], [1, 0, 1, 1]])
    axes = Figure().subplots()
    entries = hatch_cells(
        axes, x, y, status, {1: "///", 2: "", 3: "xx"}, dict.fromkeys(range(4), "")
    )
    assert [entry.get_hatch() for entry in entries] == ["///", None]
    centres = [point.ravel() for point in np.meshgrid(x, y)]
    for value, drawn in zip((1, 2), axes.collections, strict=True):
        (path,) = drawn.get_paths()
        covered = path.contains_points(np.transpose(centres)).reshape(status.shape)
        assert np.array_equal(covered, status == value)
