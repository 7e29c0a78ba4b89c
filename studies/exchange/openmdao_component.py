"""The energy balance of a parametric aircraft as a component of OpenMDAO, the extra ``openmdao``.

OpenMDAO couples analyses of several disciplines and optimises what they make up (Gray, J. S., et
al., OpenMDAO: an open-source framework for multidisciplinary design, analysis, and optimization,
Structural and Multidisciplinary Optimization, 2019).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.mass_budget import ImpossibleDesignError
from sizing.optimisation.repeated_day import DAY_OUTPUTS, DesignInDays, State
from sizing.parameters import unit
from sizing.results.quantities import CHARGE_MARGIN, EXCESS_TIME
from sizing.results.records import check_subjects
from sizing.sunlight import SolarModel, solar_day
from solar.names import CorrectionName, ModelName
from solar.types import FloatArray

if TYPE_CHECKING:
    import openmdao.api as om

_HOURS = (EXCESS_TIME.name, CHARGE_MARGIN.name)


def to_openmdao(
    aircraft: Aircraft,
    mission: Mission,
    *,
    keys: Sequence[str] = (),
    required_excess_time_h: float | None = None,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
) -> om.ExplicitComponent:
    """Aircraft on a mission as an explicit component of OpenMDAO with exact partial derivatives.

    Parameters
    ----------
    aircraft : Aircraft
        A parametric one; its own values are the defaults of the inputs.
    mission : Mission
        All of its scenarios are flown.
    keys : sequence of str
        Technology that is an input as well, such as
        ``airframe.aerodynamics.parasitic_drag_coefficient``; a colon takes the place of each dot
        in the input's name.
    required_excess_time_h : float, optional
        Excess time that the outputs ``battery_capacity`` and ``energy_balance`` ask for [h],
        instead of the mission's.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.

    Returns
    -------
    openmdao.api.ExplicitComponent

    Raises
    ------
    ImportError
        Without OpenMDAO.
    TypeError
        For a measured aircraft, or what is no aircraft or mission.
    ValueError
        For a key that is no technology of the aircraft or acts on the power of its modules, and for
        an unknown model or correction.
    """
    if find_spec("openmdao") is None:
        raise ImportError("needs OpenMDAO: pip install openmdao (the extra 'openmdao')")
    check_subjects(aircraft, mission)
    day = solar_day(aircraft, mission, SolarModel(model, correction))
    required_h = mission.required_excess_time_h
    if required_excess_time_h is not None:
        required_h = required_excess_time_h
    function = DesignInDays(aircraft, mission, day, keys, required_h=required_h)
    return _component_class()(function, len(day.scenarios))


def _openmdao_unit(name: str) -> str | None:
    """Unit of an input or output as OpenMDAO writes it; None for a number without one."""
    try:
        known = "h" if name in _HOURS else unit(name)
    except KeyError:  # a row of the requirements
        return None
    # m2 is m**2, and Wh a product.
    return None if known == "1" else re.sub(r"(?<=[a-z])(\d)", r"**\1", known.replace("Wh", "W*h"))


@cache
def _component_class() -> Any:
    """Class of the component, which needs OpenMDAO to be defined."""
    import openmdao.api as om

    class EnergyBalance(om.ExplicitComponent):  # type: ignore[misc]  # has no types
        """Mass and repeated days of a design: inputs and outputs of ``DesignInDays``."""

        def __init__(self, function: DesignInDays, scenarios: int) -> None:
            super().__init__()
            self._function, self._scenarios = function, scenarios
            self._solved: tuple[FloatArray, State] | None = None
            self._names = {name: name.replace(".", ":") for name in function.inputs}
            self._shapes = dict.fromkeys(function.scalars, 1)
            self._shapes |= dict.fromkeys(DAY_OUTPUTS, scenarios)

        def setup(self) -> None:
            for name, value in self._function.inputs.items():
                self.add_input(self._names[name], value, units=_openmdao_unit(name))
            for name, shape in self._shapes.items():
                self.add_output(name, shape=shape, units=_openmdao_unit(name))

        def setup_partials(self) -> None:
            self.declare_partials("*", "*")

        def compute(self, inputs: Any, outputs: Any) -> None:
            results = self._function.results(*self._solved_at(inputs))
            for name, part in self._parts(results).items():
                outputs[name] = part

        def compute_partials(self, inputs: Any, partials: Any) -> None:
            jacobian = self._function.jacobian(*self._solved_at(inputs))
            for name, rows in self._parts(jacobian).items():
                for column, given in enumerate(self._names.values()):
                    partials[name, given] = rows[:, column]

        def _solved_at(self, inputs: Any) -> tuple[FloatArray, State]:
            """Values of the inputs, and what they solve for: found once for both calls."""
            values = np.array([float(inputs[name].item()) for name in self._names.values()])
            if self._solved is None or not np.array_equal(values, self._solved[0]):
                try:
                    self._solved = values, self._function.solved(values)
                except ImpossibleDesignError as error:
                    raise om.AnalysisError(str(error)) from error
            return self._solved

        def _parts(self, rows: FloatArray) -> dict[str, FloatArray]:
            """Rows of each output."""
            ends = np.cumsum(list(self._shapes.values()))[:-1]
            return dict(zip(self._shapes, np.split(rows, ends), strict=True))

    return EnergyBalance
