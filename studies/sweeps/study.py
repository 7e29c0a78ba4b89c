"""Trade studies: any numeric keys of aircraft and mission varied, each point judged or sized.

Without an objective every point's design is flown by the simulator: that of the file, with what is
varied put in; a parametric design is closed, so that its mass follows. With an objective the varied
design variables are held and the others sized.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.files.errors import InputError, Problem
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.optimisation.objectives import Objective
from sizing.sunlight import SolarModel
from solar._version import __version__
from solar.names import ATTITUDE_MODELS
from studies.cli.files import LoadedAircraft, LoadedMission
from studies.engine.chunk_store import ChunkStore
from studies.engine.run import Job, Outcome, pieces, run
from studies.engine.workers import AutomaticCrew, Crew
from studies.output import columns as sizing_columns
from studies.output.columns import SIZED, SizingStatus
from studies.sweeps.axes import DESIGN_KEYS, Axis, SampleName, axis_names, points, unit_of
from studies.sweeps.points import (
    BLANKS,
    DESCRIBED,
    MISSION_PREFIX,
    SIZED_BLANKS,
    PointStatus,
    SweepConfiguration,
    judge_points,
    size_points,
    varied_files,
)

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["Study", "dataset", "feasible", "prepare", "sweep", "to_table"]

_CHUNK_S = 0.5
_CHECKED_VALUES = 50
# Design variables beyond these are no aircraft, and overflow on the way.
_LEAST, _LARGEST = 1e-9, 1e12
# Ends of this many other keys are combined to find one that makes a value right.
_COMBINED_KEYS = 6
# Times [s], roughly, that decide the size of chunks and nothing else.
_SCENARIO_S, _SCENARIO_ON_PATH_S, _AIRCRAFT_S, _SIZING_S = 3e-4, 1e-2, 3e-2, 0.25


@dataclass(frozen=True)
class Study:
    """A checked trade study, ready to be computed.

    ``points`` has the shape ``(point, axis)``; ``order`` is that in which the job's cells take
    them; ``varied`` the axis that a point of ``one-at-a-time`` varies.
    """

    axes: tuple[Axis, ...]
    sample: SampleName
    points: Any
    varied: Any
    order: Any
    job: Job
    aircraft: Aircraft
    mission: Mission
    seed: int


def sweep(
    aircraft: LoadedAircraft,
    mission: LoadedMission,
    axes: Sequence[Axis],
    solar: SolarModel | None = None,
    *,
    sample: SampleName = "grid",
    samples: int = 64,
    seed: int = 0,
    resize: Objective | None = None,
    cover: bool | None = None,
    crew: Crew | None = None,
    store: ChunkStore | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Compute a trade study.

    Parameters
    ----------
    aircraft, mission
        As :mod:`studies.cli.files` loads them.
    axes : sequence of Axis
        What is varied, see :func:`studies.sweeps.axes.parse_axis`.
    solar : SolarModel, optional
        Solar power model and its correction.
    sample, samples, seed
        Which points, see :func:`studies.sweeps.axes.points`.
    resize : Objective, optional
        Size every point for this objective.
    cover : bool, optional
        Whether the module area is the largest that the wing takes; by default where a parametric
        aircraft's wingspan or aspect ratio is varied and the module area is not.
    crew, store, progress
        See :func:`studies.engine.run.run`.

    Returns
    -------
    xarray.Dataset
        On the varied keys as dimensions for a grid, else on ``sample``; configuration and version
        in its attributes. ``status`` tells why a number is NaN.

    Raises
    ------
    InputError
        If a key or a value is wrong.
    """
    study = prepare(
        aircraft,
        mission,
        axes,
        solar or SolarModel(),
        sample=sample,
        samples=samples,
        seed=seed,
        resize=resize,
        cover=cover,
    )
    return dataset(study, run(study.job, crew or AutomaticCrew(), store, progress))


def prepare(
    aircraft: LoadedAircraft,
    mission: LoadedMission,
    axes: Sequence[Axis],
    solar: SolarModel,
    *,
    sample: SampleName = "grid",
    samples: int = 64,
    seed: int = 0,
    resize: Objective | None = None,
    cover: bool | None = None,
) -> Study:
    """Check a trade study and divide it into chunks; parameters as those of :func:`sweep`."""
    _check(aircraft, mission, axes, resize, cover, combined=sample != "one-at-a-time")
    base = None
    if sample == "one-at-a-time":
        base = [_base_value(aircraft.aircraft, mission.mission, axis) for axis in axes]
    try:
        table, varied = points(axes, sample, base=base, samples=samples, seed=seed)
    except ValueError as error:
        raise _vary_error("", str(error)) from None
    order = _order(axes, table)
    configuration = SweepConfiguration(
        aircraft.document.data,
        mission.document.data,
        tuple(axis.key for axis in axes),
        solar,
        _covers(aircraft.aircraft, axes, resize, cover),
        resize,
    )
    each = _points_per_chunk(mission.mission, axes, solar, resize)
    cells = [tuple(float(value) for value in table[i]) for i in order]
    chunks = tuple(tuple(cells[piece]) for piece in pieces(len(cells), each))
    blanks = BLANKS if resize is None else SIZED_BLANKS
    job = Job(judge_points if resize is None else size_points, configuration, chunks, blanks)
    return Study(
        tuple(axes), sample, table, varied, order, job, aircraft.aircraft, mission.mission, seed
    )


# ---- Checks


def _vary_error(key: str, message: str) -> InputError:
    return InputError([Problem(f"--vary {key}".rstrip(), None, None, "", message)])


def _check(
    aircraft: LoadedAircraft,
    mission: LoadedMission,
    axes: Sequence[Axis],
    resize: Objective | None,
    cover: bool | None,
    *,
    combined: bool,
) -> None:
    """Refuse what no point could make sense of: every value must be right in one at least."""
    if not axes:
        raise _vary_error("", "nothing is varied")
    measured = isinstance(aircraft.aircraft.airframe, MeasuredAirframe)
    if measured and cover:
        raise _vary_error("", "--cover needs a parametric aircraft, this one is measured")
    if measured and resize is not None:
        raise _vary_error("", "--resize needs a parametric aircraft, this one is measured")
    for number, axis in enumerate(axes):
        if any(other.key == axis.key for other in axes[:number]):
            raise _vary_error(axis.key, "is varied twice")
        if measured and axis.design_variable in ("wingspan_m", "aspect_ratio"):
            raise _vary_error(
                axis.key,
                "a measured aircraft's power does not follow from its wing; take a parametric one",
            )
        if resize is Objective.min_wingspan and axis.design_variable == "wingspan_m":
            raise _vary_error(axis.key, "is varied and cannot be minimised as well")
        others = [*axes[:number], *axes[number + 1 :]] if combined else []
        _check_values(aircraft, mission, axis, others)


def _check_values(
    aircraft: LoadedAircraft, mission: LoadedMission, axis: Axis, others: Sequence[Axis]
) -> None:
    if axis.design_variable is not None:
        # Alone a design variable may contradict the others, which is no mistake of the user.
        least = 0.0 if axis.design_variable == "module_area_m2" else _LEAST
        low, high = min(axis.values), max(axis.values)
        if low < least or high > _LARGEST:
            wrong = low if low < least else high
            raise _vary_error(axis.key, f"must be from {least:g} to {_LARGEST:g} (got {wrong:g})")
        return
    for value in _telling_values(axis.values):
        error = _wrong(aircraft, mission, {axis.key: value})
        # What the file's other values forbid may be right with those that they are varied to.
        if error is not None and not any(
            _wrong(aircraft, mission, {axis.key: value} | corner) is None
            for corner in _corners(others)
        ):
            hint = _meant(axis.key)
            if hint is not None:
                raise _vary_error(axis.key, hint)
            problem = replace(error.problems[0], source=f"--vary {axis.key}", line=None)
            raise InputError([problem])


def _wrong(
    aircraft: LoadedAircraft, mission: LoadedMission, values: Mapping[str, float]
) -> InputError | None:
    """What is wrong with values put into the files, none if nothing is."""
    try:
        varied_files(aircraft.document, mission.document, list(values), list(values.values()))
    except InputError as error:
        return error
    return None


def _corners(axes: Sequence[Axis]) -> Iterator[dict[str, float]]:
    """Combinations of the least and largest values of some axes."""
    some = axes[:_COMBINED_KEYS]
    ends = [(min(axis.values), max(axis.values)) for axis in some]
    for values in itertools.product(*ends) if some else ():
        yield {axis.key: value for axis, value in zip(some, values, strict=True)}


def _meant(key: str) -> str | None:
    """What is meant by the first word of a key that no aircraft file has; None for one it has."""
    first = key.partition(".")[0]
    if first in Aircraft.model_fields or key.startswith(MISSION_PREFIX):
        return None
    if first in Mission.model_fields:
        return f"is a key of the mission: write {MISSION_PREFIX}{key}"
    close = get_close_matches(key, DESIGN_KEYS, n=1)
    if close:
        return f"unknown key; did you mean {close[0]!r}?"
    allowed = ", ".join([*DESIGN_KEYS, *Aircraft.model_fields, "mission"])
    return f"unknown key; allowed: {allowed}"


def _telling_values(values: Sequence[float]) -> list[float]:
    """Values worth a check of their own: of many the ends, and the first that is no integer."""
    if len(values) <= _CHECKED_VALUES:
        return list(values)
    broken = [value for value in values if value != round(value)][:1]
    return [min(values), max(values), *broken]


def _base_value(aircraft: Aircraft, mission: Mission, axis: Axis) -> float:
    """Value that the file gives a key."""
    on_mission = axis.key.startswith(MISSION_PREFIX)
    node: Any = mission if on_mission else aircraft
    for part in axis.key.removeprefix(MISSION_PREFIX).split("."):
        is_index = isinstance(node, list | tuple) and part.isdecimal()
        node = node[int(part)] if is_index else getattr(node, part, None)
    if isinstance(node, bool) or not isinstance(node, int | float):
        raise _vary_error(axis.key, "has no single number in the file to start from")
    return float(node)


def _covers(
    aircraft: Aircraft, axes: Sequence[Axis], resize: Objective | None, cover: bool | None
) -> bool:
    """Whether the modules fill the wing."""
    varied = {axis.design_variable for axis in axes}
    parametric = not isinstance(aircraft.airframe, MeasuredAirframe)
    if resize is not None:
        if cover:
            raise _vary_error("", "--cover: with --resize the module area is sized, or varied")
        return False
    if cover and "module_area_m2" in varied:
        raise _vary_error("modules.area_m2", "is varied and cannot follow the wing as well")
    if cover is not None:
        return cover
    return (
        parametric
        and bool(varied & {"wingspan_m", "aspect_ratio"})
        and ("module_area_m2" not in varied)
    )


# ---- Points in chunks


def _order(axes: Sequence[Axis], table: Any) -> Any:
    """Order in which points with the same aircraft and mission stand together: one batch."""
    other = [table[:, i] for i, axis in enumerate(axes) if axis.design_variable is None]
    if not other:
        return np.arange(len(table))
    return np.lexsort([np.arange(len(table)), *other[::-1]])


def _points_per_chunk(
    mission: Mission, axes: Sequence[Axis], solar: SolarModel, resize: Objective | None
) -> int:
    on_path = solar.model in ATTITUDE_MODELS or solar.correction == "loiter"
    scenarios = len(mission.scenarios())
    day_s = scenarios * _SCENARIO_ON_PATH_S if on_path else 0.0
    if resize is not None:
        point_s = _SIZING_S + day_s
    else:
        batched = any(axis.design_variable is not None for axis in axes)
        point_s = scenarios * _SCENARIO_S + (0.0 if batched else _AIRCRAFT_S + day_s)
    return max(round(_CHUNK_S / point_s), 1)


# ---- Results


def dataset(study: Study, outcome: Outcome) -> xr.Dataset:
    """Columns of a study with their units, on a grid or along the samples."""
    import xarray as xr

    objective = study.job.configuration.objective
    described = sizing_columns.DESCRIBED | DESCRIBED
    place = np.argsort(study.order)
    columns = {name: values[place] for name, values in outcome.columns.items()}
    for number, text in outcome.failures.items():
        messages = columns["message"].astype(object)
        messages[study.order[number]] = text
        columns["message"] = messages.astype(str)
    names = axis_names(study.axes)
    coords: dict[str, Any] = {}
    grid = study.sample == "grid"
    dims = tuple(names) if grid else ("sample",)
    shape = tuple(len(axis.values) for axis in study.axes) if grid else (len(study.points),)
    for i, (name, axis) in enumerate(zip(names, study.axes, strict=True)):
        about = {"units": unit_of(axis.key), "long_name": axis.key}
        values = np.array(axis.values) if grid else study.points[:, i]
        coords[name] = ((name,) if grid else ("sample",), values, about)
    if study.sample == "one-at-a-time":
        varied = [names[i] if i >= 0 else "" for i in study.varied]
        coords["varied"] = (("sample",), varied, {"long_name": "what differs from the file"})
    variables = {
        name: (dims, columns[name].reshape(shape), {"units": text[0], "long_name": text[1]})
        for name, text in described.items()
        if name in columns and name not in coords  # the aspect ratio may be varied
    }
    flags = PointStatus if objective is None else SizingStatus
    status = columns["status"].reshape(shape)
    variables["status"] = (dims, status, sizing_columns.flag_attributes(flags))
    return xr.Dataset(variables, coords=coords, attrs=_attributes(study))


def _attributes(study: Study) -> dict[str, Any]:
    configuration: SweepConfiguration = study.job.configuration
    objective = configuration.objective
    required = study.mission.required_excess_time_h
    vary = {axis.key: list(axis.values) for axis in study.axes}
    return {
        "Conventions": "CF-1.11",
        "title": f"Trade study of {study.aircraft.name} on {study.mission.name}",
        "source": f"solar-uav {__version__}",
        "vary": json.dumps(vary),
        "sample": study.sample,
        "seed": study.seed,
        "modules_cover_the_wing": int(configuration.cover),
        "objective": "" if objective is None else objective.value,
        "required_excess_time_h": required,
        "solar_model": configuration.solar.model,
        "correction": configuration.solar.correction,
        "aircraft": study.aircraft.model_dump_json(),
        "mission": study.mission.model_dump_json(),
    }


def to_table(data: xr.Dataset) -> pd.DataFrame:
    """One row per point; the status in words, attributes of the data in those of the table."""
    names = dict(
        zip(
            data["status"].attrs["flag_values"].tolist(),
            data["status"].attrs["flag_meanings"].split(),
            strict=True,
        )
    )
    table = data.to_dataframe().reset_index()
    table["status"] = [names[int(value)] for value in table["status"]]
    first = [str(name) for name in data.coords if name in table.columns]
    rest = [name for name in table.columns if name not in (*first, "status", "sample")]
    table = table[[*first, "status", *rest]]
    table.attrs = dict(data.attrs)
    return table


def feasible(data: xr.Dataset) -> xr.DataArray:
    """Mark the points that fly for ever, or that were sized."""
    if data.attrs["objective"]:
        return data["status"].isin(SIZED)
    return data["status"].isin([PointStatus.perpetual, PointStatus.always_lit])
