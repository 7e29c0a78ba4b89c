"""What a report is about: an aircraft on a mission, and all that was asked of them."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from missions.files.overrides import with_values
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.day.module_power import path_troubles
from sizing.results.analysis import Analysis, analyse
from sizing.results.uncertainty import analyse_uncertainty
from sizing.results.weather import analyse_weather
from studies.models.comparison import compare
from studies.models.solar_models import attitude_is_known
from studies.output.run_folder import RunInputs, run_record
from studies.render.analysis import sections

if TYPE_CHECKING:
    from missions.weather.record import Weather
    from sizing.results.uncertainty import UncertaintyAnalysis
    from sizing.results.weather import WeatherAnalysis
    from studies.flight_logs.verification import Verification
    from studies.models.comparison import Comparison

# Draws of uncertain inputs: a second or two, and probabilities to within two per cent.
SAMPLES = 2048
_MOST_SCENARIOS = 30  # of which so many draws are flown unasked
_MOST_LATITUDES = 3


@dataclass(frozen=True)
class Subject:
    """What a report is about; results are computed when a section asks for them.

    ``aircraft``, ``mission``, ``solar``: what is reported on, and by which solar power model.
    ``inputs``: files as they went in. ``sizing``: record of the sizing that the aircraft came from.
    ``verification``: models against a flight log; the report is then about that.
    ``weather_record``: record to fly through. ``with_uncertainty``: whether inputs scatter; None
    where aircraft or mission has uncertain inputs. ``overrides``: values that replaced those of the
    files, as ``--set`` has them. ``mission_is_default``: whether nobody chose the mission.
    ``known_mass_kg``: total mass, where it is known. ``project``, ``author``: for the head.
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    inputs: RunInputs
    sizing: Mapping[str, Any] | None = None
    verification: Verification | None = None
    weather_record: Weather | None = None
    with_uncertainty: bool | None = None
    overrides: tuple[str, ...] = ()
    mission_is_default: bool = False
    known_mass_kg: float | None = None
    project: str = ""
    author: str = ""

    @cached_property
    def analysis(self) -> Analysis:
        """Aircraft on its mission."""
        others = vars(self.solar) | {"known_mass_kg": self.known_mass_kg}
        return analyse(self.aircraft, self.mission, **others)

    @cached_property
    def sections(self) -> dict[str, list[Any]]:
        """Blocks of the analysis, by what they are about."""
        return sections(self.analysis)

    @cached_property
    def record(self) -> dict[str, Any]:
        """Analysis as ``analyse --json`` prints it."""
        return {**self.analysis.to_dict(), "mission_is_default": self.mission_is_default}

    @cached_property
    def path_trouble(self) -> str | None:
        """Why VM and FM cannot fly the path in the wind; None if they can, or have none."""
        if not attitude_is_known(self.aircraft, self.mission):
            return None
        return path_troubles(self.aircraft, self.mission)[0]

    @cached_property
    def comparison(self) -> Comparison | None:
        """Solar power models side by side; None in a wind too strong for the path.

        Of a mission with many latitudes at that of its weakest scenario: the season of VM and FM
        takes a second or two at each.
        """
        if self.path_trouble is not None:
            return None
        mission, several = self.mission, len(self.mission.latitudes()) > _MOST_LATITUDES
        if several and attitude_is_known(self.aircraft, mission):
            weakest = self.analysis.worst_scenario.latitude_deg
            mission = with_values(mission, {"latitude_deg": weakest, "launch": None})
        return compare(self.aircraft, mission, design=False)

    @property
    def has_uncertain_inputs(self) -> bool:
        """Whether a file says how its inputs scatter."""
        return self.aircraft.uncertainty is not None or self.mission.uncertainty is not None

    @property
    def uncertainty_is_quick(self) -> bool:
        """Whether flights of all draws take no more than a few seconds."""
        return len(self.mission.scenarios()) <= _MOST_SCENARIOS

    @cached_property
    def uncertainty(self) -> UncertaintyAnalysis | None:
        """Flights under draws of the uncertain inputs, where there are any or asked for."""
        by_default = self.has_uncertain_inputs and self.uncertainty_is_quick
        if not (by_default if self.with_uncertainty is None else self.with_uncertainty):
            return None
        return analyse_uncertainty(self.aircraft, self.mission, **vars(self.solar), samples=SAMPLES)

    @cached_property
    def weather(self) -> WeatherAnalysis | None:
        """Flight through the weather record, where there is one."""
        if self.weather_record is None:
            return None
        options = vars(self.solar) | {"mission_chosen": not self.mission_is_default}
        return analyse_weather(self.aircraft, self.mission, self.weather_record, **options)

    @cached_property
    def run(self) -> dict[str, Any]:
        """Command line, software, date and files of the report."""
        run = run_record(self.solar, self.inputs.files)
        if sys.argv[:1] and not sys.argv[0].endswith("solar-uav"):
            run["command"] = shlex.join(["python", *sys.argv]) if sys.argv[0] else "python"
        return run

    def results(self) -> dict[str, Any]:
        """Return every record that the report shows, JSON-ready."""
        if self.verification is not None:
            return {"verification": self.verification.to_dict()}
        sizing = {} if self.sizing is None else {"sizing": dict(self.sizing)}
        others = {name: getattr(self, name) for name in ("comparison", "uncertainty", "weather")}
        known = {name: each.to_dict() for name, each in others.items() if each is not None}
        return {"analysis": self.record, **sizing, **known}
