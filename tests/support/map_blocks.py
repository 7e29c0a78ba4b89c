"""Cells of a map as plain arrays, computed as one block."""

from studies.maps.study import prepare


def map_block(aircraft, mission, latitudes, days, solar, endurance=False):
    """Return the columns of a map, shape ``(latitude, day)``."""
    study = prepare(aircraft, mission, latitudes, days, solar, endurance=endurance)
    shape = [len(one.values) for one in study.coordinates.values()]
    columns = study.function(study.configuration, study.cells)
    return {name: values.reshape(shape) for name, values in columns.items()}
