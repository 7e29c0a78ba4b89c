"""What tests of the command line share: its outcome, and files to give it."""

import json
from typing import NamedTuple

BIRD = """\
name: bird
airframe:
  kind: measured
  wingspan_m: 5.65
  aspect_ratio: 18.5
  mass_without_battery_kg: 4.0
  level_flight:
    electric_power_w: 35.8
    mass_kg: 6.92
    density_kg_per_m3: 1.10
modules:
  area_m2: 1.35
  efficiency_stc: 0.237
battery:
  mass_kg: 2.918
  specific_energy_wh_per_kg: 251
  charge_limit:
    kind: table
    state_of_charge: [0.8, 0.9, 1.0]
    current_a: [10, 5, 1]
    voltage_v: 25
    pack_energy_wh: 732
power:
  avionics_w: 6.0
"""

FIELD = """\
name: field
latitude_deg: 47.6
longitude_deg: 8.5
dates:
  on: 07-15
altitude_m: 500
air:
  ambient_temperature_c: 20.0
clearness: 1.0
turbulence:
  thermal: 0.0
launch:
  date: 07-14
  time_local: 09:30
  utc_offset_h: 2
  duration_h: 30
"""


class Outcome(NamedTuple):
    code: int
    out: str
    err: str

    def good(self):
        """The outcome itself, of a command that had nothing to say of mistakes."""
        assert (self.code, self.err) == (0, "")
        return self

    def json(self):
        """Standard output as strict JSON: NaN and Infinity are refused."""

        def refuse(constant):
            raise AssertionError(f"{constant} is not JSON")

        return json.loads(self.out, parse_constant=refuse)


def edited(text, old, new):
    assert text.count(old) == 1, old
    return text.replace(old, new)


def files(folder):
    return {path.name for path in folder.iterdir()}
