"""User-defined models by name: structure, drag, mass and efficiency of the propulsion.

Functions use arithmetic, or functions of NumPy and CasADi, for floats, arrays and symbols:
simulator and optimiser call the same function.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from sizing.smooth import Value

StructureFunction: TypeAlias = Callable[[Any], Value]  # of StructureInputs
DragFunction: TypeAlias = Callable[[Value, Value, Value], Value]
PropulsionMassFunction: TypeAlias = Callable[[Value], Value]
PropulsionEfficiencyFunction: TypeAlias = Callable[[Value, Value, Value], Value]

_KNOWN: dict[str, dict[str, Callable[..., Value]]] = {
    "structure": {},
    "drag": {},
    "propulsion_mass": {},
    "propulsion_efficiency": {},
}


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
    _register("structure", "model of the structure", name, mass_kg)


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
    _register("drag", "drag model", name, drag_coefficient)


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
    _register("propulsion_mass", "mass model of the propulsion", name, mass_kg)


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
    _register("propulsion_efficiency", "efficiency of the propulsion", name, efficiency)


def user_function(kind: str, name: str) -> Callable[..., Value]:
    """Return the function of a kind, ``structure``, ``drag`` ..., that is registered by a name."""
    known = _KNOWN[kind]
    if name not in known:
        known_names = f"known are {', '.join(known)}" if known else "none is registered"
        raise ValueError(f"{name!r} is not registered by sizing.register_{kind}: {known_names}")
    return known[name]


def _register(kind: str, what: str, name: str, function: Callable[..., Value]) -> None:
    if name in _KNOWN[kind]:
        raise ValueError(f"there is a {what} {name} already")
    _KNOWN[kind][name] = function
