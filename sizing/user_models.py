"""User-defined models by name: structure, drag, mass and efficiency of the propulsion.

Functions use arithmetic, or functions of NumPy and CasADi, for floats, arrays and symbols:
simulator and optimiser call the same function.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

from sizing.smooth import Value

F = TypeVar("F")

StructureFunction: TypeAlias = Callable[[Any], Value]  # of StructureInputs
DragFunction: TypeAlias = Callable[[Value, Value, Value], Value]
PropulsionMassFunction: TypeAlias = Callable[[Value], Value]
PropulsionEfficiencyFunction: TypeAlias = Callable[[Value, Value, Value], Value]

_STRUCTURES: dict[str, StructureFunction] = {}
_DRAGS: dict[str, DragFunction] = {}
_PROPULSION_MASSES: dict[str, PropulsionMassFunction] = {}
_PROPULSION_EFFICIENCIES: dict[str, PropulsionEfficiencyFunction] = {}


def register_structure(name: str, mass_kg: StructureFunction) -> None:
    """Register a model of the structure, for ``structure: {model: own, name: ...}``.

    Models are registered in the current process only: the workers of a long map must register them
    themselves.

    Parameters
    ----------
    name : str
        A name that is not taken.
    mass_kg : callable
        From :class:`~sizing.structures.loads.StructureInputs` (``wingspan_m``, ``aspect_ratio``,
        ``total_mass_kg``, ``span_load_kg``, ``airspeed_m_per_s`` ...) to the structural mass [kg].

    Raises
    ------
    ValueError
        If the name is taken.
    """
    _register(_STRUCTURES, "model of the structure", name, mass_kg)


def register_drag(name: str, drag_coefficient: DragFunction) -> None:
    """Register a drag model, for ``aerodynamics: {model: own, name: ...}``.

    Parameters
    ----------
    name : str
        A name that is not taken.
    drag_coefficient : callable
        From lift coefficient, aspect ratio and Reynolds number of the mean chord to the drag
        coefficient of the whole aircraft on its wing area [-].

    Raises
    ------
    ValueError
        If the name is taken.
    """
    _register(_DRAGS, "drag model", name, drag_coefficient)


def register_propulsion_mass(name: str, mass_kg: PropulsionMassFunction) -> None:
    """Register a mass model of the propulsion, for ``propulsion: {mass_model: ...}``.

    Parameters
    ----------
    name : str
        A name that is not taken.
    mass_kg : callable
        From the rated electric power [W] to the mass of the propulsion group [kg].

    Raises
    ------
    ValueError
        If the name is taken.
    """
    _register(_PROPULSION_MASSES, "mass model of the propulsion", name, mass_kg)


def register_propulsion_efficiency(name: str, efficiency: PropulsionEfficiencyFunction) -> None:
    """Register an efficiency of the propulsion, for ``propulsion: {efficiency_model: ...}``.

    Parameters
    ----------
    name : str
        A name that is not taken.
    efficiency : callable
        From power of level flight at the propeller [W] (drag times airspeed), airspeed [m/s] and
        air density [kg/m3] to the efficiency of the whole chain from the battery bus to thrust [-].

    Raises
    ------
    ValueError
        If the name is taken.
    """
    _register(_PROPULSION_EFFICIENCIES, "efficiency of the propulsion", name, efficiency)


def structure_function(name: str) -> StructureFunction:
    """Return the structural model of a name; ValueError if there is none."""
    return _named(_STRUCTURES, "register_structure", name)


def drag_function(name: str) -> DragFunction:
    """Return the drag model of a name; ValueError if there is none."""
    return _named(_DRAGS, "register_drag", name)


def propulsion_mass_function(name: str) -> PropulsionMassFunction:
    """Return the mass model of the propulsion of a name; ValueError if there is none."""
    return _named(_PROPULSION_MASSES, "register_propulsion_mass", name)


def propulsion_efficiency_function(name: str) -> PropulsionEfficiencyFunction:
    """Return the efficiency of the propulsion of a name; ValueError if there is none."""
    return _named(_PROPULSION_EFFICIENCIES, "register_propulsion_efficiency", name)


def _register(known: dict[str, F], what: str, name: str, function: F) -> None:
    if name in known:
        raise ValueError(f"there is a {what} {name} already")
    known[name] = function


def _named(known: dict[str, F], register: str, name: str) -> F:
    if name not in known:
        known_names = f"known are {', '.join(known)}" if known else "none is registered"
        raise ValueError(f"{name!r} is not registered by sizing.{register}: {known_names}")
    return known[name]
