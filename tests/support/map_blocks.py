"""Cells of a map as plain arrays, computed as one block."""

from typing import Any

from numpy.typing import ArrayLike, NDArray

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from studies.maps.study import prepare


def map_block(
    aircraft: Aircraft,
    mission: Mission,
    latitudes: ArrayLike,
    days: ArrayLike,
    solar: SolarModel,
    endurance: bool = False,
) -> dict[str, NDArray[Any]]:
    """Return the columns of a map, shape ``(latitude, day)``."""
    study = prepare(aircraft, mission, latitudes, days, solar, endurance=endurance)
    shape = [len(one.values) for one in study.coordinates.values()]
    columns = study.function(study.configuration, study.cells)
    return {name: values.reshape(shape) for name, values in columns.items()}
