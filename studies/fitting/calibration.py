"""A parametric aircraft that weighs and consumes what a measured one does.

A measured aircraft has a mass and a power, but no model of them: it cannot be sized. The technology
of a parametric aircraft gives the models; one factor on its drag and one on its structure make them
meet the measured numbers. Modules, battery and consumers are those of the measured aircraft.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from missions.air import (
    GAS_CONSTANT_AIR,
    GRAVITY_M_PER_S2,
    MAXIMUM_ALTITUDE_M,
    MINIMUM_ALTITUDE_M,
    ZERO_CELSIUS_K,
    standard_air,
)
from missions.files.errors import InputError, Problem
from missions.files.overrides import Overrides, with_overrides
from missions.files.shipped import find_document
from missions.files.validation import located_error, validate
from missions.files.yaml import Document
from missions.mission import Mission
from sizing.aircraft import Aircraft, LevelFlight, MeasuredAirframe, ParametricAirframe
from sizing.design import FlightConditions, parametric_design, variables_of
from sizing.mass_budget import closed_design
from sizing.parameters import all_replaced, parameter, parameter_value
from sizing.propulsion.chain import Propulsion
from sizing.results.quantities import ASPECT_RATIO, WINGSPAN
from sizing.results.tables import Column, Line, Result, Summary, Table
from solar.modules import STC_IRRADIANCE_W_PER_M2
from studies.fitting.files import provenance, renamed
from studies.fitting.parameters import PARAMETERS, power_name

# Mass and power of the calibrated aircraft agree with the measured ones to this, relative.
_AGREE = 1e-6
_OF_THE_MEASURED = ("modules", "battery", "power")
_SIZE = (WINGSPAN.name, ASPECT_RATIO.name)


@dataclass(frozen=True)
class Factor:
    """A number of the technology that was changed: its key, values, and the catalogue's range."""

    key: str
    before: float
    after: float
    minimum: float | None
    maximum: float | None
    source: str

    @property
    def inside(self) -> bool:
        """Whether the value is one that has been built or is in sight."""
        low = self.minimum is None or self.after >= self.minimum
        return low and (self.maximum is None or self.after <= self.maximum)


@dataclass(frozen=True, repr=False)
class Calibration(Result):
    """A parametric aircraft that reproduces a measured one.

    Attributes
    ----------
    measured, technology : str
        Names of the aircraft that it was made of.
    aircraft : Aircraft
        Parametric.
    document : Document
        Its file.
    factors : tuple of Factor
        What was changed of the technology.
    agreement : tuple
        Rows of quantity, unit, measured and parametric value.
    """

    measured: str
    technology: str
    aircraft: Aircraft
    document: Document
    factors: tuple[Factor, ...]
    agreement: tuple[tuple[str, str, float, float], ...]

    def headline(self) -> str:
        """What was made of what."""
        return f"{self.aircraft.name}: {self.measured} with the technology of {self.technology}"

    def summary(self) -> Summary:
        """Headline, what was changed, and what agrees."""
        factors = Table(
            "technology",
            (
                Column("key"),
                Column("before", self.technology, form=".4g"),
                Column("after", "calibrated", form=".4g"),
                Column("minimum", "least", form=".4g"),
                Column("maximum", "most", form=".4g"),
                Column("source", "from"),
            ),
            tuple(map(astuple, self.factors)),
        )
        columns = (
            Column("quantity"),
            Column("unit"),
            Column("measured", form=".4g"),
            Column("parametric", form=".4g"),
        )
        agreement = Table("agreement", columns, self.agreement)
        return Summary((Line(self.headline(), "strong"), factors, agreement))

    def to_dict(self) -> dict[str, Any]:
        """What was changed and what agrees, JSON-ready."""
        return {
            "aircraft": self.aircraft.name,
            "measured": self.measured,
            "technology": self.technology,
            "factors": [vars(one) for one in self.factors],
            "agreement": [
                dict(zip(("quantity", "unit", "measured", "parametric"), row, strict=True))
                for row in self.agreement
            ],
        }


def calibrate_aircraft(
    measured: str | os.PathLike[str], technology: str | os.PathLike[str], overrides: Overrides = ()
) -> Calibration:
    """Make a parametric aircraft of a measured one, so that it can be sized.

    Parameters
    ----------
    measured : str or path
        Name or file of a measured aircraft.
    technology : str or path
        Name or file of a parametric one.
    overrides : mapping or sequence of str
        Keys of ``technology`` to change, as of :func:`sizing.load_aircraft`.

    Returns
    -------
    Calibration
        Its ``aircraft`` is the parametric one.

    Raises
    ------
    InputError
        As by :func:`calibrate`.
    """
    built, models = (find_document("aircraft", os.fspath(one)) for one in (measured, technology))
    return calibrate(built, with_overrides(models, overrides))


def calibrate(
    measured: Document, technology: Document, sources: Mapping[str, str | None] | None = None
) -> Calibration:
    """Parametric aircraft with the mass, level power and module power of a measured one."""
    built, models = validate(measured, Aircraft), validate(technology, Aircraft)
    _check_kinds(measured, technology, built, models)
    known = built.airframe
    assert isinstance(known, MeasuredAirframe)
    mass_kg = known.mass_without_battery_kg + built.battery.mass_kg
    start, changes = _combined(built, known, models)
    flight = _level_flight(built, known.level_flight.density_kg_per_m3)
    drag_key = PARAMETERS[power_name(start)].key
    drag = _drag(start, known.level_flight, flight, drag_key)
    start = all_replaced(start, {drag_key: drag})
    structure_key = _structure_key(start)
    structure = _structure(start, flight, mass_kg, structure_key)
    changes |= {drag_key: (drag, "level power"), structure_key: (structure, "total mass")}
    factors = tuple(_factor_on(models, key, *change) for key, change in changes.items())
    _check_ranges(technology, factors)
    document = _document(measured, technology, factors, dict(sources or {}))
    aircraft = validate(document, Aircraft)
    agreement = _agreement(built, known.level_flight, mass_kg, aircraft, flight)
    return Calibration(built.name, models.name, aircraft, document, factors, agreement)


def _check_kinds(
    measured: Document, technology: Document, built: Aircraft, models: Aircraft
) -> None:
    problems: list[Problem] = []
    both = ((measured, built, "measured"), (technology, models, "parametric"))
    for document, aircraft, wanted in both:
        kind = aircraft.airframe.kind
        if kind != wanted:
            message = f"must be {wanted} (got {kind}): the measured aircraft first"
            problems += located_error(document, ("airframe", "kind"), message).problems
    if models.propulsion_by_parts is not None:
        key, message = ("airframe", "propulsion", "kind"), "must be constant to be calibrated"
        problems += located_error(technology, key, message).problems
    if problems:
        raise InputError(problems)


def _combined(
    built: Aircraft, known: MeasuredAirframe, models: Aircraft
) -> tuple[Aircraft, dict[str, tuple[float, str]]]:
    """Technology in the measured aircraft's size, and what its file changes of it by itself."""
    frame = models.airframe
    assert isinstance(frame, ParametricAirframe)
    level, propulsion = known.level_flight, frame.propulsion
    assert isinstance(propulsion, Propulsion)
    changes: dict[str, tuple[float, str]] = {}
    if level.airspeed_m_per_s is not None:
        area_m2 = known.wingspan_m**2 / known.aspect_ratio
        pressure = 0.5 * level.density_kg_per_m3 * level.airspeed_m_per_s**2
        lift = level.mass_kg * GRAVITY_M_PER_S2 / (pressure * area_m2)
        changes["airframe.aerodynamics.lift_coefficient"] = (lift, "airspeed")
    if level.propulsion_efficiency is not None:
        others = propulsion.efficiency / propulsion.propeller_efficiency
        propeller = level.propulsion_efficiency / others
        changes["airframe.propulsion.propeller_efficiency"] = (propeller, "propulsion efficiency")
    if level.maximum_electric_power_w is not None and propulsion.climb_rate_m_per_s is None:
        ratio = level.maximum_electric_power_w / level.electric_power_w
        changes["airframe.propulsion.climb_power_ratio"] = (ratio, "largest power")
    coverage = built.modules.area_m2 * known.aspect_ratio / known.wingspan_m**2
    if coverage > frame.maximum_module_coverage:
        changes["airframe.maximum_module_coverage"] = (min(coverage, 1.0), "module area")
    values = {part: getattr(built, part) for part in _OF_THE_MEASURED}
    values |= {f"airframe.{key}": getattr(known, key) for key in _SIZE}
    values |= {key: changed for key, (changed, _) in changes.items()}
    return all_replaced(models, values), changes


def _level_flight(built: Aircraft, density: float) -> FlightConditions:
    """Conditions of the measured level flight: standard air of its density."""
    altitudes = np.linspace(MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M, 65001)
    densities = standard_air(altitudes).density_kg_per_m3
    altitude_m = float(np.interp(-density, -densities, altitudes))
    here = standard_air(altitude_m)
    # Beyond the atmosphere's ends the temperature makes the density.
    kelvin = float(here.pressure_pa) / (GAS_CONSTANT_AIR * density)
    place = {"latitude_deg": 0.0, "dates": {"on": "06-21"}, "altitude_m": altitude_m}
    air = {"ambient_temperature_c": float(np.clip(kelvin - ZERO_CELSIUS_K, -100.0, 100.0))}
    mission = Mission.model_validate({"name": "level flight", **place, "air": air})
    return FlightConditions.of(mission, built)._replace(density_kg_per_m3=density)


def _power_w(aircraft: Aircraft, flight: FlightConditions, mass_kg: float) -> float:
    design = parametric_design(aircraft, flight, variables_of(aircraft), mass_kg)
    return float(design.propulsion_power_w)


def _drag(start: Aircraft, level: LevelFlight, flight: FlightConditions, key: str) -> float:
    """Drag that takes the measured power, which rises in a straight line with the key."""
    now = parameter_value(start, None, key)
    assert now is not None  # power_name names a key of the model
    low, high = (
        _power_w(all_replaced(start, {key: value}), flight, level.mass_kg)
        for value in (now, 2.0 * now)
    )
    return now * (1.0 + (level.electric_power_w - low) / (high - low))


def _structure_key(aircraft: Aircraft) -> str:
    """Key that the whole structural mass is proportional to."""
    name = "calibration"
    if parameter_value(aircraft, None, f"airframe.structure.{name}") is None:
        name = "coefficient_kg"
    return f"airframe.structure.{name}"


def _structure(start: Aircraft, flight: FlightConditions, mass_kg: float, key: str) -> float:
    """Factor of the structure with which the budget adds up to the measured mass."""
    masses = parametric_design(start, flight, variables_of(start), mass_kg).masses
    left_kg = mass_kg - (float(masses.total_kg) - float(masses.structure))
    now = parameter_value(start, None, key)
    assert now is not None  # _structure_key looked
    return now * left_kg / float(masses.structure)


def _factor_on(models: Aircraft, key: str, after: float, source: str) -> Factor:
    before = parameter_value(models, None, key)
    try:
        known = parameter(key)
    except KeyError:
        return Factor(key, before or 0.0, after, None, None, source)
    return Factor(key, before or 0.0, after, known.minimum, known.maximum, source)


def _check_ranges(technology: Document, factors: tuple[Factor, ...]) -> None:
    problems = []
    for one in factors:
        if not one.inside:
            message = (
                f"would have to be {one.after:.4g} for the measured {one.source}; "
                f"allowed: {one.minimum:g} to {one.maximum:g}, what has been built or is in sight. "
                f"Other technology, or other masses with --set, may fit"
            )
            problems.append(Problem(technology.source, None, None, one.key, message))
    if problems:
        raise InputError(problems)


def _document(
    measured: Document,
    technology: Document,
    factors: tuple[Factor, ...],
    sources: dict[str, str | None],
) -> Document:
    """File of the calibrated aircraft."""
    values: dict[str, Any] = {f"airframe.{key}": measured.data["airframe"][key] for key in _SIZE}
    values |= {one.key: float(f"{one.after:.9g}") for one in factors}
    values |= {part: copy.deepcopy(measured.data[part]) for part in _OF_THE_MEASURED}
    name = measured.data["name"]
    values["name"] = renamed(name, "parametric")
    values["description"] = f"{name} with the technology of {technology.data['name']}, calibrated"
    # Inputs that scatter: of the airframe those of the technology, else the measured ones.
    inputs: dict[str, Any] = {}
    for document, own in ((technology, True), (measured, False)):
        given = (document.data.get("uncertainty") or {}).get("inputs") or {}
        inputs |= {key: v for key, v in given.items() if key.startswith("airframe.") == own}
    inputs = {key: value for key, value in inputs.items() if "level_flight" not in key}
    if inputs:
        values["uncertainty"] = {"inputs": inputs}
    else:
        data = {key: value for key, value in technology.data.items() if key != "uncertainty"}
        technology = Document(technology.source, data)
    origin = provenance(measured, "calibrate", sources)
    values["provenance"] = {**origin, "technology": technology.source}
    return with_overrides(technology, values)


def _agreement(
    built: Aircraft,
    level: LevelFlight,
    mass_kg: float,
    aircraft: Aircraft,
    flight: FlightConditions,
) -> tuple[tuple[str, str, float, float], ...]:
    """Measured quantities beside those of the parametric aircraft, whose budget is closed anew."""
    closed = closed_design(aircraft, flight, variables_of(aircraft))
    consumed_w = _power_w(aircraft, flight, level.mass_kg)
    rated, modelled = (
        STC_IRRADIANCE_W_PER_M2 * one.modules.efficiency_stc * one.modules.area_m2
        for one in (built, aircraft)
    )
    measured_wh, energy_wh = (one.battery.battery_energy_wh for one in (built, aircraft))
    rows = (
        ("total mass", "kg", mass_kg, float(closed.total_mass_kg)),
        ("power of level flight", "W", level.electric_power_w, consumed_w),
        ("module power at standard conditions", "W", rated, modelled),
        ("battery energy", "Wh", measured_wh, energy_wh),
    )
    for name, unit, wanted, estimate in rows:
        if not abs(estimate - wanted) <= _AGREE * max(wanted, 1.0):
            message = f"{name} cannot be met: {estimate:.6g} {unit} instead of {wanted:.6g} {unit}"
            raise InputError([Problem(aircraft.name, None, None, "", message)])
    return rows
