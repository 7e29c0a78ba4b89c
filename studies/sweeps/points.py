"""Points of a trade study as workers compute them: simulated, or sized beside what is varied."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from missions.files.errors import InputError
from missions.files.overrides import with_values
from missions.files.texts import texts_as_read
from missions.mission import Mission
from sizing import mass_budget
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.heights import ClimbLimitError, climb_limits
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import Status
from sizing.design import DesignVariables, variables_of
from sizing.design_space import DesignSpace, Range
from sizing.limits import MASS_BUDGET, design_requirements
from sizing.parameters import MISSION_PREFIX, all_replaced
from sizing.performance import Performance, performance
from sizing.program.objectives import Objective, SizingStatus
from sizing.smooth import Value
from sizing.validity.checks import flight_checks
from sizing.validity.extrapolations import as_text, cell_texts, extrapolations
from solar.schema import spell
from solar.types import FloatArray
from studies.engine.run import blanks_of
from studies.output import gridded
from studies.quantities import (
    CHOSEN,
    DESIGN_COLUMNS,
    ENDURANCE,
    LOAD,
    MAXIMUM_ALTITUDE,
    PAYLOAD_MASS,
    PAYLOAD_POWER,
    REACHED,
    TOTAL_MASS,
    described,
)
from studies.render.words import percent
from studies.sweeps.axes import DESIGN_KEYS, DESIGN_VARIABLES

_DESCRIBED = gridded.DESCRIBED | {
    ENDURANCE.variable: ("h", "longest flight in the worst scenario; infinite where perpetual"),
    MAXIMUM_ALTITUDE.variable: ("m", "highest altitude of the day in the worst scenario"),
    **described("worst_latitude worst_day"),
}
_OF_SIZINGS = (PAYLOAD_POWER.variable, "shortfall")


@dataclass(frozen=True)
class SweepConfiguration:
    """Inputs common to all points.

    ``tables``: texts of files that the aircraft names, for workers on other machines. ``names``: by
    key, names whose indices are the values. ``cover``: the module area is the largest that the wing
    takes. ``total_mass_kg``: of all simulated points, if known.
    """

    aircraft: Aircraft
    mission: Mission
    keys: tuple[str, ...]
    solar: SolarModel
    objective: Objective | None
    tables: Mapping[str, str]
    names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    cover: bool = False
    total_mass_kg: float | None = None

    @property
    def measured(self) -> bool:
        """Whether the aircraft's masses and power are measured ones."""
        return isinstance(self.aircraft.airframe, MeasuredAirframe)

    def files(self, values: Mapping[str, float]) -> tuple[Aircraft, Mission]:
        """Return aircraft and mission with values set by key, checked like files.

        Keys of the mission begin with ``mission.``; a value below 0 keeps a name of the file.
        """
        of_aircraft, of_mission = dict[str, Any](), dict[str, Any]()
        for key, value in values.items():
            # An integer passes for a real, but not the other way round.
            whole = value == round(value) and abs(value) < 1e15
            number = int(value) if whole else float(value)
            if key in self.names and value < 0.0:
                continue
            of_record = of_mission if key.startswith(MISSION_PREFIX) else of_aircraft
            chosen = self.names[key][int(value)] if key in self.names else number
            of_record[key.removeprefix(MISSION_PREFIX)] = chosen
        with texts_as_read(self.tables):
            return with_values(self.aircraft, of_aircraft), with_values(self.mission, of_mission)

    @property
    def described(self) -> dict[str, tuple[str, str]]:
        """Unit and long name of the columns of points."""
        if self.objective is not None:
            return gridded.DESCRIBED
        climbs = self.mission.climb is not None or varies_climb(self.keys)
        lacking = _OF_SIZINGS if climbs else (*_OF_SIZINGS, MAXIMUM_ALTITUDE.variable)
        return {name: texts for name, texts in _DESCRIBED.items() if name not in lacking}


def varies_climb(keys: Iterable[str]) -> bool:
    """Return true if a key belongs to the mission's climbs."""
    return any(key.startswith(f"{MISSION_PREFIX}climb.") for key in keys)


def _reason_not_to_fly(
    solar: SolarModel, aircraft: Aircraft, mission: Mission
) -> tuple[str, str] | None:
    """Return requirement and reason if an aircraft cannot climb, or hold the path in wind."""
    if mission.climb is not None and isinstance(aircraft.airframe, MeasuredAirframe):
        try:
            climb_limits(aircraft, mass_budget.measured_design(aircraft, mission))
        except ClimbLimitError as error:
            return "climb", str(error)
    (trouble,) = solar.path_troubles(aircraft, mission)
    return None if trouble is None else (gridded.TOO_WINDY, f"flight path: {trouble}")


def valid_groups(
    configuration: SweepConfiguration,
    cells: FloatArray,
    rows: dict[int, dict[str, Any]],
    statuses: type[Status] | type[SizingStatus],
) -> Iterator[tuple[list[int], Aircraft, Mission]]:
    """Yield indices of cells that differ in design variables alone, with aircraft and mission.

    Sets the rows of cells that are invalid or cannot fly.
    """
    measured = configuration.measured
    in_files = [measured or key not in DESIGN_VARIABLES for key in configuration.keys]
    keys = list(itertools.compress(configuration.keys, in_files))
    groups: dict[tuple[float, ...], list[int]] = {}
    for number, cell in enumerate(cells):
        groups.setdefault(tuple(itertools.compress(cell, in_files)), []).append(number)
    for values, numbers in groups.items():
        try:
            aircraft, mission = configuration.files(dict(zip(keys, values, strict=True)))
        except InputError as error:
            text = "; ".join(f"{problem.key}: {problem.message}" for problem in error.problems)
            row: dict[str, Any] = {"status": statuses.invalid, "message": text}
        else:
            trouble = _reason_not_to_fly(configuration.solar, aircraft, mission)
            if trouble is None:
                yield numbers, aircraft, mission
                continue
            requirement, text = trouble
            row = {
                "status": statuses.infeasible,
                "violated_requirement": requirement,
                "message": text,
            }
        rows |= dict.fromkeys(numbers, row)


def simulate_points(configuration: SweepConfiguration, cells: FloatArray) -> dict[str, Any]:
    """Simulate the designs of points; points that differ in design variables alone are a batch.

    ``cells``: values of ``configuration.keys``, shape ``(point, key)``. Returns the columns that
    ``configuration.described`` lists.
    """
    rows: dict[int, dict[str, Any]] = {}
    for numbers, aircraft, mission in valid_groups(configuration, cells, rows, Status):
        known_kg = configuration.total_mass_kg
        if isinstance(aircraft.airframe, MeasuredAirframe):
            if known_kg is not None:
                try:
                    aircraft = mass_budget.with_total_mass(aircraft, mission, known_kg)
                except mass_budget.ImpossibleDesignError as error:
                    row = {"status": Status.infeasible, "violated_requirement": "parts"}
                    rows |= dict.fromkeys(numbers, row | {"message": str(error)})
                    continue
            result = performance(aircraft, mission, configuration.solar)
            row = _row_of_design(result, mission, (), {})
            row["extrapolations"] = as_text(extrapolations(aircraft, result))
            rows |= dict.fromkeys(numbers, row)  # the same point, if it is there twice
            continue
        variables = _variables(configuration, aircraft, cells[numbers])
        day = solar_day(aircraft, mission, configuration.solar)
        closed = (aircraft, mission, variables)
        design = (
            mass_budget.closed_design(*closed)
            if known_kg is None
            else mass_budget.design_of_total_mass(*closed, known_kg)
        )
        result = performance(aircraft, mission, configuration.solar, day=day, design=design)
        violations = _violations(aircraft, mission, result, known_kg)
        texts = cell_texts(flight_checks(aircraft, result), len(numbers))
        for place, number in enumerate(numbers):
            rows[number] = row = _row_of_design(result, mission, (place,), violations)
            if row["status"] is not Status.infeasible:
                row["extrapolations"] = texts[place]
            elif not np.isfinite(result.design.total_mass_kg[place]):
                chosen = variables.chosen().items()
                point = DesignVariables(**{name: float(value[place]) for name, value in chosen})
                if trouble := mass_budget.operating_trouble(aircraft, mission, point):
                    row |= {"violated_requirement": "operating_point", "message": trouble}
    return columns_of(configuration, rows)


def columns_of(
    configuration: SweepConfiguration, rows: Mapping[int, Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the columns of rows, in the order of their numbers, blank where a row lacks one."""
    blanks, ordered = blanks_of(configuration.described), [row for _, row in sorted(rows.items())]
    return {name: [row.get(name, blank) for row in ordered] for name, blank in blanks.items()}


def _variables(
    configuration: SweepConfiguration, aircraft: Aircraft, cells: FloatArray
) -> DesignVariables:
    varied = dict(zip(map(DESIGN_VARIABLES.get, configuration.keys), cells.T, strict=True))
    chosen = variables_of(aircraft).chosen().items()
    variables = DesignVariables(
        **{name: varied.get(name, np.full(len(cells), value)) for name, value in chosen}
    )
    if not configuration.cover:
        return variables
    coverage = getattr(aircraft.airframe, "maximum_module_coverage", 1.0)
    covered_m2 = coverage * variables.wingspan_m**2 / variables.aspect_ratio
    return variables._replace(module_area_m2=covered_m2)


def _violations(
    aircraft: Aircraft, mission: Mission, result: Performance, known_kg: float | None
) -> dict[str, tuple[FloatArray, str]]:
    """Return the violations of requirements that sizings have as well, by name.

    Each by every design [-], with its text.
    """
    design = result.design
    with np.errstate(invalid="ignore"):
        rows = {
            r.name: (np.asarray(r.value), r.text)
            for r in design_requirements(aircraft, design)
            if r.name != MASS_BUDGET
        }
    mass = np.asarray(design.total_mass_kg)
    afloat = np.where(np.isfinite(mass), 0.0, -np.inf)
    unable = "the design cannot carry its own mass"
    if known_kg is None:
        rows[MASS_BUDGET] = (afloat, unable)
    else:
        text = f"the parts weigh more than the total mass of {spell(known_kg)} kg"
        rows["parts"] = (afloat, text)
    heaviest = aircraft.design_space.maximum_total_mass_kg
    if heaviest is not None:
        rows["total_mass"] = (1.0 - mass / heaviest, "the total mass exceeds its limit by {missed}")
    return {name: (np.maximum(-value, 0.0), text) for name, (value, text) in rows.items()}


# Rounding must not refuse a wing that is filled exactly.
_ROUNDING = 1e-9


def _row_of_design(
    result: Performance,
    mission: Mission,
    place: tuple[int, ...],
    violations: Mapping[str, tuple[FloatArray, str]],
) -> dict[str, Any]:
    """Return the row of a design."""
    design = result.design
    row: dict[str, Any] = {each.variable: _value_at(each.of(design), place) for each in CHOSEN}
    row[PAYLOAD_MASS.variable] = mission.payload.mass_kg
    every = {name: float(amount[place]) for name, (amount, _) in violations.items()}
    amounts = {name: amount for name, amount in every.items() if amount > _ROUNDING}
    if amounts:
        most = max(amounts, key=lambda name: amounts[name])
        # For a design that cannot fly the other reasons mean nothing.
        reported = [most] if np.isinf(amounts[most]) else list(amounts)
        missed = {name: percent(amount, ".3g") for name, amount in amounts.items()}
        texts = [violations[n][1].format(missed=missed[n]) for n in reported]
        return row | {
            "status": Status.infeasible,
            "violated_requirement": most,
            "message": "; ".join(texts),
        }
    cycle = result.cycle
    excess = cycle.excess_time_h[place]
    worst = int(np.argmin(excess))
    scenarios = result.day.scenarios
    if result.maximum_altitude_m is not None:
        row[MAXIMUM_ALTITUDE.variable] = float(result.maximum_altitude_m[place][worst])
    return row | {
        "status": Status(int(cycle.status[place][worst])),
        TOTAL_MASS.variable: _value_at(TOTAL_MASS.of(design), place),
        **{each.variable: float(each.of(result)[place][worst]) for each in (*REACHED, LOAD)},
        ENDURANCE.variable: _value_at(result.worst_endurance_h, place),
        "worst_latitude": float(scenarios.latitude_deg[worst]),
        "worst_day": float(scenarios.day_of_year[worst]),
    }


def _value_at(values: Value, place: tuple[int, ...]) -> float:
    return float(np.asarray(values)[place])


# ---- Sized


def with_fixed_variables(aircraft: Aircraft, variables: Mapping[str, float]) -> Aircraft:
    """Return an aircraft with design variables, by short names, fixed at values.

    Their bounds coincide, which makes the solver drop them from the problem.
    """
    space: dict[str, Any] = {
        name: Range.model_construct(minimum=value, maximum=value)
        for name, value in variables.items()
        if name != "aspect_ratio"
    }
    if "aspect_ratio" in variables:
        space["aspect_ratio"] = None  # fixed at the airframe's
    design_space: DesignSpace = aircraft.design_space.model_copy(update=space)
    values = {DESIGN_KEYS[name]: value for name, value in variables.items()}
    return all_replaced(aircraft, values).model_copy(update={"design_space": design_space})


def size_points(configuration: SweepConfiguration, cells: FloatArray) -> dict[str, Any]:
    """Size points with the varied design variables fixed; arguments as ``simulate_points``."""
    assert configuration.objective is not None
    rows: dict[int, dict[str, Any]] = {}
    for numbers, aircraft, mission in valid_groups(configuration, cells, rows, SizingStatus):
        for number in numbers:
            names = map(DESIGN_VARIABLES.get, configuration.keys)
            values = zip(names, cells[number].tolist(), strict=True)
            fixed = {name: value for name, value in values if name is not None}
            sized = with_fixed_variables(aircraft, fixed)
            try:
                rows[number] = _sizing_row(
                    sized, mission, configuration.objective, configuration.solar, of=aircraft
                )
            except mass_budget.ImpossibleDesignError as error:
                rows[number] = {"status": SizingStatus.infeasible, "message": str(error)}
    return columns_of(configuration, rows)


def _sizing_row(
    aircraft: Aircraft, mission: Mission, objective: Objective, solar: SolarModel, *, of: Aircraft
) -> dict[str, Any]:
    """Size a point of a trade study; ``of``: aircraft without the point's fixed variables."""
    from sizing.program.size import size_aircraft  # with the optimiser, a seventh of a second

    result = size_aircraft(aircraft, mission, objective, solar)
    row: dict[str, Any] = {"status": result.status, PAYLOAD_MASS.variable: mission.payload.mass_kg}
    if result.status is SizingStatus.not_converged:
        return row | {"message": f"the solver did not converge ({result.solver.message})"}
    if result.violations:
        worst = max(result.violations, key=lambda v: v.shortfall)
        row |= {"shortfall": worst.shortfall, "violated_requirement": worst.requirement}
        row |= {"message": "; ".join(v.text for v in result.violations)}
    if result.simulated is None or result.design is None:
        return row
    simulated, scenario = result.simulated, result.simulated.worst_scenario()
    row |= {q.variable: q.of(result.design) for q in DESIGN_COLUMNS}
    row |= {q.variable: float(q.of(simulated)[scenario]) for q in (*REACHED, LOAD)}
    return row | {"extrapolations": as_text(extrapolations(of, simulated))}
