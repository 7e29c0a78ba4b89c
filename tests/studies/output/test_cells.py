"""Cells of maps: reasons in words."""

import numpy as np
from matplotlib.figure import Figure

from sizing.parameters import label
from studies.output.cells import hatch_cells
from studies.output.gridded import requirement_label


def test_requirements_are_told_in_words():
    assert requirement_label("sun") == "polar night"
    assert requirement_label("battery_capacity") == "battery: does not last the night"
    limit = f"limit: {label('wing_loading_kg_per_m2')}"
    assert requirement_label("wing_loading_kg_per_m2_maximum") == limit
    assert requirement_label("") == "no design"


def test_all_cells_of_a_hatch_are_one_path():
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
