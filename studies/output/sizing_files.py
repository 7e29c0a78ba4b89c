"""Files of a sizing: the sized aircraft, the mission that it flies, tables and figures."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from missions.dates import date_code
from missions.mission.mission import MAXIMUM_SCENARIOS
from sizing.program.objectives import Objective
from sizing.results.analysis import Analysis, analyse
from sizing.results.result import data_frame
from sizing.results.sizing_study import SizingStudy
from sizing.structures.rib_wing import RibWingStructure
from studies.output import design_plots
from studies.output.cycle_plots import plot_cycle
from studies.output.figures.options import DEFAULT, FigureOptions
from studies.output.formats import csv_bytes
from studies.output.run_folder import RunInputs
from studies.render.words import extrapolation_caption
from studies.serialise import serialise

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Keys of a mission that play no part in a weather record.
_NOT_OF_A_RECORD = ("launch", "clearness", "required_excess_time_h")


def sized_inputs(study: SizingStudy, inputs: RunInputs) -> RunInputs:
    """Return the sized aircraft, and the mission that it was sized for, as files.

    Analysed, they give the excess time of the sizing: the mission has the payload that the optimum
    carries, the range of days or latitudes that it covers, and the site of a weather record.
    """
    mission: dict[str, Any] = copy.deepcopy(dict(inputs.mission))
    coverage = study.coverage
    if coverage is not None and coverage.first is not None and coverage.last is not None:
        first, last, count = coverage.first, coverage.last, len(coverage.members)
        if coverage.sizing.objective is Objective.longest_season:
            assert coverage.sizing.simulated is not None
            latitudes = len(coverage.sizing.simulated.day.scenarios) // count
            ends = {"from": date_code(int(first)), "to": date_code(int(last))}
            most = min(count, MAXIMUM_SCENARIOS // latitudes)
            mission["dates"] = {"on": ends["from"]} if count == 1 else {**ends, "count": most}
        else:
            mission.pop("launch", None)  # a flight has a single latitude
            across = {"from_deg": first, "to_deg": last, "count": min(count, 181)}
            mission["latitude_deg"] = first if count == 1 else across
    if study.survival is not None:
        site = study.survival.weather.site
        mission = {key: mission[key] for key in mission if key not in _NOT_OF_A_RECORD}
        mission |= {"latitude_deg": site.latitude_deg, "longitude_deg": site.longitude_deg}
    carried = study.sized_mission().payload
    if carried != study.mission.payload:
        mission["payload"] = carried.model_dump()
    aircraft = study.sized_aircraft().model_dump(mode="json", exclude_unset=True)
    return dataclasses.replace(inputs, aircraft=aircraft, mission=mission)


def sizing_tables(study: SizingStudy) -> dict[str, bytes]:
    """Return the tables of an optimum by the names of their files."""
    contents = {
        "scenarios.csv": csv_bytes(study.scenarios()),
        "masses.csv": csv_bytes(study.masses()),
    }
    if study.sensitivities:
        contents["sensitivities.csv"] = csv_bytes(data_frame(serialise(study.sensitivities)))
    return contents


def sizing_figures(
    study: SizingStudy, figure: FigureOptions = DEFAULT
) -> dict[str, Callable[[], Figure]]:
    """Return functions that draw an optimum, by the names of their files.

    Sensitivities, where there are any, come as a tornado plot, whole cells on their wing.
    """
    result, sensitivities, solar = study.result, study.sensitivities, study.solar
    assert result.design is not None
    masses, sized = result.design.masses._asdict(), study.sized_aircraft()
    mission, outside = study.sized_mission(), study.extrapolations

    @cache
    def analysis() -> Analysis:
        return analyse(sized, mission, **vars(solar), replay=False)

    title, notes = f"{sized.name}: mass budget", (extrapolation_caption(outside),)
    drawings: dict[str, Callable[[], Figure]] = {
        "cycle.png": lambda: plot_cycle(analysis(), figure=figure),
        "masses.png": lambda: design_plots.plot_masses(masses, title, notes=notes, figure=figure),
    }
    if isinstance(getattr(sized.airframe, "structure", None), RibWingStructure):
        drawings["flight-envelope.png"] = lambda: design_plots.plot_flight_envelope(
            analysis(), figure=figure
        )
    if sized.modules.layout is not None:
        drawings["cells.png"] = lambda: design_plots.plot_cells(sized, figure=figure)
    if sensitivities:
        drawings["sensitivities.png"] = lambda: design_plots.plot_sensitivities(
            sensitivities, result.objective, sized.name, solar, extrapolations=outside,
            figure=figure,
        )  # fmt: skip
    return drawings
