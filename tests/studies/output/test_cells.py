"""Cells of maps: colours in equal steps, reasons in words."""

from __future__ import annotations

import numpy as np
import pytest

from sizing.parameters import label
from studies.output.cells import diverging, requirement_label


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
