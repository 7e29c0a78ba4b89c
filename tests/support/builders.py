"""Aircraft and missions that the tests share."""

from functools import cache
from pathlib import Path

import yaml

from missions.library import load_mission
from missions.mission import Mission
from sizing.climb import compare_with_constant
from sizing.library import load_aircraft
from sizing.performance import performance


@cache
def aircraft(name, *overrides):
    """Return a shipped aircraft, changed as by ``--set``."""
    return load_aircraft(name, overrides)


AS2 = aircraft("atlantiksolar-as2")
UNLIMITED_AS2 = aircraft("atlantiksolar-as2", "battery.charge_limit={kind: none}")
DESIGN = aircraft("atlantiksolar-design")
SKY_SAILOR = aircraft("sky-sailor")
# Overrides of `DESIGN`: wings of up to 4 m, from a small first guess.
SMALL_WINGS = (
    "design_space.wingspan_m.maximum=4.0",
    "airframe.wingspan_m=3.5",
    "modules.area_m2=0.5",
)


def mission(**changes):
    """Return a plain day in July at AtlantikSolar's airfield, changed."""
    plain = {"name": "test", "latitude_deg": 47.6, "dates": {"on": "07-15"}, "altitude_m": 536.0}
    return Mission.model_validate(plain | changes)


HARD_CASES = Path(__file__).parents[1] / "sizing" / "program" / "hard_cases.yaml"


@cache
def hard_case(name):
    """Return aircraft and mission of a case that is hard to size, and the rest of its row."""
    row = dict(yaml.safe_load(HARD_CASES.read_text("utf-8"))[name])
    plane = load_aircraft(row.pop("aircraft"), row.pop("changes"))
    return plane, mission(**row.pop("mission")), row


def shipped_mission(name="rafz-july", **changes):
    """Return a shipped mission with whole keys of its file replaced."""
    plain = load_mission(name).model_dump(by_alias=True, exclude_none=True)
    return Mission.model_validate(plain | changes)


def climb_performance(flown, where, *solar):
    """Return the flights of a mission with climbs beside those at its lowest altitude."""
    return compare_with_constant(flown, performance(flown, where, *solar))
