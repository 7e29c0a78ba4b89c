"""Trade studies: any numeric keys of aircraft and mission varied, each point simulated or sized.

Without an objective the aircraft with each point's values is simulated; the mass of a parametric
design follows from its budget. With an objective the varied design variables are fixed and the
others sized.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from missions.files.errors import InputError, Problem, did_you_mean
from missions.files.writing import to_json
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.day.metrics import ENDS, Status
from sizing.parameters import MISSION_PREFIX, value_at
from sizing.program.objectives import Objective, SizingStatus
from sizing.validity.checks import check_user_models
from solar.names import CorrectionName, ModelName
from solar.schema import refusal, spell_ends
from solar.types import FloatArray, IntArray
from studies.engine.run import VARIED, Study
from studies.output import gridded
from studies.quantities import ASPECT_RATIO, WINGSPAN
from studies.sweeps.axes import (
    DESIGN_KEYS,
    SAMPLE_NAMES,
    Axis,
    SampleName,
    axes_of,
    axis_names,
    points,
    shown_value,
    unit_of,
)
from studies.sweeps.points import (
    SweepConfiguration,
    simulate_points,
    size_points,
    varies_climb,
)

if TYPE_CHECKING:
    import xarray as xr

_WING = {WINGSPAN.name, ASPECT_RATIO.name}

_CHECKED_VALUES = 50
# Design variables outside this range overflow on the way.
_LEAST, _LARGEST = 1e-9, 1e12
# Ends of this many other keys are combined to find one that makes a value right.
_COMBINED_KEYS = 6
# Rough time of a point [s], by its parts.
_SCENARIO_S, _SCENARIO_ON_PATH_S, _AIRCRAFT_S, _SIZING_S = 3e-4, 1e-2, 3e-2, 0.25
_CLIMB_S = 5e-2  # of the program of a day
_ALTITUDE = f"{MISSION_PREFIX}altitude_m"


def sweep(
    aircraft: Aircraft,
    mission: Mission,
    vary: Mapping[str, ArrayLike],
    *,
    resize: str | Objective | None = None,
    cover: bool | None = None,
    sample: SampleName = "grid",
    samples: int = 64,
    seed: int = 0,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    workers: int | None = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Compute a trade study.

    Parameters
    ----------
    aircraft : Aircraft
        What flies.
    mission : Mission
        Where, when and in which air.
    vary : mapping
        Values by key: of the aircraft's file, of the mission's behind ``mission.``, or
        ``wingspan_m``, ``aspect_ratio``, ``battery_mass_kg``, ``module_area_m2``. Drawn samples
        lie between the least and the largest value. ``modules.cell``, ``battery.cell`` and
        ``airframe.propulsion.motor`` take names of the catalogues.
    resize : str or Objective, optional
        Size every point for this objective: ``min_wingspan``, ``min_mass``, ``max_excess_time``,
        ``max_payload_mass`` or ``max_payload_power``. Varied design variables are held.
    cover : bool, optional
        Whether the module area is the largest that the wing takes; by default where a parametric
        aircraft's wingspan or aspect ratio is varied and the module area is not.
    sample : {"grid", "lhs", "sobol", "one-at-a-time"}, optional
        Which points, see :func:`studies.sweeps.axes.points`.
    samples, seed : int, optional
        Number of drawn points, and where the drawing starts.
    model, correction, workers, scheduler, progress
        See :func:`studies.maps.study.feasibility_map`.

    Returns
    -------
    xarray.Dataset
        On the varied keys as dimensions for a grid, else on ``sample``; configuration and version
        in its attributes. ``status`` tells why a number is NaN. Points that could not be computed
        have the status ``failed``; the attribute ``failed_cells`` lists them, and a warning counts
        them.

    Raises
    ------
    InputError
        If a key or a value is wrong (a ValueError).
    ValueError
        If a name is none of those allowed.
    ComputationError
        If every point failed.
    """
    study = prepare(
        aircraft,
        mission,
        axes_of(vary),
        SolarModel(model, correction),
        sample=sample,
        samples=samples,
        seed=seed,
        resize=resize,
        cover=cover,
    )
    return study.computed(workers, scheduler, progress).to_xarray()


def prepare(
    aircraft: Aircraft,
    mission: Mission,
    axes: Sequence[Axis],
    solar: SolarModel,
    *,
    sample: SampleName = "grid",
    samples: int = 64,
    seed: int = 0,
    resize: str | Objective | None = None,
    cover: bool | None = None,
    total_mass_kg: float | None = None,
) -> Study:
    """Check a trade study and return it.

    ``samples``, ``seed``: number of drawn points, and seed of the generator. ``cover``: the module
    area is the largest that the wing takes. ``total_mass_kg``: of every simulated point, if known.
    """
    if sample not in SAMPLE_NAMES:
        raise ValueError(f"unknown sample {sample!r}; allowed: {', '.join(SAMPLE_NAMES)}")
    check_user_models(aircraft, mission)
    objective = None if resize is None else gridded.resize_objective(resize)
    configuration = SweepConfiguration(
        aircraft,
        mission,
        tuple(axis.key for axis in axes),
        solar,
        objective,
        aircraft.texts_read,
        {axis.key: axis.names for axis in axes if axis.names},
        total_mass_kg=total_mass_kg,
    )
    one_at_a_time = sample == "one-at-a-time"
    covers = _checked_cover(configuration, axes, cover, combined=not one_at_a_time)
    configuration = replace(configuration, cover=covers)
    base = [_base_value(aircraft, mission, axis) for axis in axes] if one_at_a_time else None
    try:
        table, varied = points(axes, sample, base=base, samples=samples, seed=seed)
    except ValueError as error:
        raise _error("", str(error)) from None
    title = f"Trade study of {aircraft.name} on {mission.name}"
    about = gridded.attributes(title, aircraft, mission, solar)
    if varies_climb(configuration.keys) or (
        gridded.CLIMB in about and _ALTITUDE in configuration.keys
    ):
        about[gridded.CLIMB] = "with climbs"
    scenarios = len(mission.scenarios())
    day_s = scenarios * solar.needs_path * _SCENARIO_ON_PATH_S
    if objective is None:
        climbs = mission.climb is not None or varies_climb(configuration.keys)
        batched = any(axis.design_variable is not None for axis in axes)
        alone_s = 0.0 if batched else _AIRCRAFT_S + day_s
        cell_s = scenarios * (_SCENARIO_S + climbs * _CLIMB_S) + alone_s
    else:
        cell_s = _SIZING_S + day_s
    # Points with the same aircraft and mission are adjacent, a batch.
    of_files = [table[:, i] for i, axis in enumerate(axes) if axis.design_variable is None]
    order = np.lexsort([np.arange(len(table)), *of_files[::-1]])
    sized = objective is not None
    with_result = gridded.SIZED if sized else ENDS
    return Study(
        size_points if sized else simulate_points,
        configuration,
        table,
        cell_s=cell_s,
        described=configuration.described,
        statuses=tuple(SizingStatus if sized else Status),
        coordinates=_coordinates(axes, sample, table, varied),
        attributes={
            **about,
            "vary": to_json({axis.key: list(axis.names or axis.values) for axis in axes}),
            "sample": sample,
            "seed": seed,
            "modules_cover_the_wing": int(configuration.cover),
            "objective": "" if objective is None else objective.value,
            "required_excess_time_h": mission.required_excess_time_h,
        },
        extrapolated=lambda columns: gridded.told_of_cells(columns, with_result, "points"),
        order=order,
        unit="points",
    )


# ---- Checks


def _error(key: str, message: str) -> InputError:
    return InputError([Problem(key or "the study", None, None, "", message)])


def _checked_cover(
    configuration: SweepConfiguration, axes: Sequence[Axis], cover: bool | None, *, combined: bool
) -> bool:
    """Refuse a study with values that are right at no point; return whether modules fill wings.

    ``combined``: points differ from the file in several keys at once.
    """
    if not axes:
        raise _error("", "nothing is varied")
    objective, measured = configuration.objective, configuration.measured
    if measured and (cover or objective is not None):
        option = "cover" if cover else "resize"
        raise _error("", f"{option} needs a parametric aircraft, this one is measured")
    for number, axis in enumerate(axes):
        if any(other.key == axis.key for other in axes[:number]):
            raise _error(axis.key, "is varied twice")
        if measured and axis.design_variable in _WING:
            raise _error(
                axis.key,
                "a measured aircraft's power does not follow from its wing; take a parametric one",
            )
        if objective is not None and axis.design_variable == objective.variable:
            raise _error(axis.key, "is varied and cannot be minimised as well")
        others = [*axes[:number], *axes[number + 1 :]] if combined else []
        _check_values(configuration, axis, others)
    varied = {axis.design_variable for axis in axes}
    if objective is not None and cover:
        raise _error("", "cover: with resize the module area is sized, or varied")
    if cover and "module_area_m2" in varied:
        raise _error("modules.area_m2", "is varied and cannot follow the wing as well")
    if cover is not None or objective is not None:
        return bool(cover)
    return not measured and bool(varied & _WING) and "module_area_m2" not in varied


def _check_values(configuration: SweepConfiguration, axis: Axis, others: Sequence[Axis]) -> None:
    """Refuse values of a key that are wrong with all of the other keys' ends."""
    key, values = axis.key, axis.values
    low, high = min(values), max(values)
    if axis.design_variable is not None:
        # A design variable alone may contradict the file's others, which is no mistake.
        least = 0.0 if axis.design_variable == "module_area_m2" else _LEAST
        if low < least or high > _LARGEST:
            wrong = low if low < least else high
            raise _error(key, refusal(f"must be from {spell_ends((least, _LARGEST))}", wrong))
        return
    if len(values) > _CHECKED_VALUES:  # the ends, and the first that is no integer
        values = (low, high, *[value for value in values if value != round(value)][:1])
    combined = others[:_COMBINED_KEYS]
    ends = [[(other.key, end(other.values)) for end in (min, max)] for other in combined]
    corners = list(map(dict, itertools.product(*ends))) if ends else []
    for value in values:
        error = _trouble(configuration, {key: value})
        # A value that the file's other values forbid may be right at other points.
        if error is None or any(
            _trouble(configuration, {key: value} | corner) is None for corner in corners
        ):
            continue
        first = key.partition(".")[0]
        if first in Aircraft.model_fields or key.startswith(MISSION_PREFIX):
            raise InputError([replace(error.problems[0], source=key, line=None)])
        if first in Mission.model_fields:
            raise _error(key, f"is a key of the mission: write {MISSION_PREFIX}{key}")
        allowed = ", ".join([*DESIGN_KEYS, *Aircraft.model_fields, "mission"])
        meant = did_you_mean(key, DESIGN_KEYS) or f"; allowed: {allowed}"
        raise _error(key, f"unknown key{meant}")


def _trouble(configuration: SweepConfiguration, values: Mapping[str, float]) -> InputError | None:
    """Return the error of values set in the files, None if they are right."""
    try:
        configuration.files(values)
    except InputError as error:
        return error
    return None


def _base_value(aircraft: Aircraft, mission: Mission, axis: Axis) -> float:
    """Return the file's value of a key."""
    if axis.names:
        return -1.0  # the file's own, whatever it is
    on_mission = axis.key.startswith(MISSION_PREFIX)
    key = axis.key.removeprefix(MISSION_PREFIX)
    value = value_at(mission if on_mission else aircraft, key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _error(axis.key, "has no single number in the file to start from")
    return float(value)


# ---- Results


def _coordinates(
    axes: Sequence[Axis], sample: SampleName, table: FloatArray, varied: IntArray
) -> dict[str, gridded.Labelled]:
    """Return the varied keys as coordinates: a dimension each in a grid, else along samples."""
    coordinates, names = {}, axis_names(axes)
    for name, axis, drawn in zip(names, axes, table.T, strict=True):
        dims, places = ((name,), axis.values) if sample == "grid" else (("sample",), drawn)
        values = np.array([shown_value(axis, place) for place in places])
        about = {"units": unit_of(axis.key), "long_name": axis.key}
        coordinates[name] = gridded.Labelled(dims, values, about)
    if sample == "one-at-a-time":
        words = np.array([names[i] if i >= 0 else "" for i in varied])
        coordinates[VARIED] = gridded.Labelled(
            ("sample",), words, {"long_name": "what differs from the file"}
        )
    return coordinates
