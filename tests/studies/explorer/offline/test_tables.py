"""Tables of the offline page, and its modules as one; what the page makes of them: test_page.py."""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import missions
import sizing
from sizing.mass_budget import design_of
from studies.explorer.offline.page import bundled
from studies.explorer.offline.tables import Axis, design_table, light_table, quantised


def numbers_of(table: dict[str, Any]) -> Any:
    """Table as the page reads it."""
    integers = np.frombuffer(base64.b64decode(table["base64"]), "<i2").reshape(table["shape"])
    values = table["offset"] + table["scale"] * integers
    return np.where(integers == table["impossible"], np.nan, values)


@pytest.mark.parametrize(
    "values",
    [[0.0, 1.0, 1e3], [-5.0, -4.999, 7.0], [3.0, 3.0, 3.0], [math.nan, 1.0, 2.0], [math.inf]],
)
def test_integers_keep_numbers_to_a_part_in_65534_of_their_range(values: list[float]) -> None:
    given = np.array(values)
    finite = given[np.isfinite(given)]
    span = float(np.ptp(finite)) if len(finite) else 0.0
    found = numbers_of(quantised(given))
    assert np.array_equal(np.isnan(found), ~np.isfinite(given))
    assert_allclose(found[np.isfinite(given)], finite, rtol=1e-15, atol=span / 65534 / 2 * 1.001)


def test_axis_has_the_ends_and_the_start() -> None:
    axis = Axis.between("battery.mass_kg", 0.88, 7.3, 2.918)
    assert {0.88, 2.918, 7.3} <= set(axis.values)
    assert np.all(np.diff(axis.values) > 0.0)
    assert list(Axis.between("mission.payload.mass_kg", 0.0, 0.0, 0.0).values) == [0.0]


@pytest.mark.parametrize("name", ["atlantiksolar-design", "atlantiksolar-as2"])
def test_design_at_the_start_is_that_of_the_files(name: str) -> None:
    aircraft, mission = sizing.load_aircraft(name), missions.load_mission("rafz-july")
    axes = [
        Axis.between("battery.mass_kg", 1.0, 6.0, aircraft.battery.mass_kg),
        Axis.between("modules.area_m2", 1.0, 1.5, aircraft.modules.area_m2),
        Axis.between("mission.payload.mass_kg", 0.0, 2.0, mission.payload.mass_kg),
    ]
    table = design_table(aircraft, mission, axes)
    place = tuple(
        record["values"].index(pytest.approx(value))
        for record, value in zip(
            table["axes"],
            (aircraft.battery.mass_kg, aircraft.modules.area_m2, mission.payload.mass_kg),
            strict=True,
        )
    )
    design = design_of(aircraft, mission)
    # A step of the integers is at most a 65534th of what the logarithm spans, below 2 here.
    for name, value in (
        ("log_mass_kg", design.total_mass_kg),
        ("log_power_w", design.propulsion_power_w),
        ("log_airspeed_m_per_s", design.airspeed_m_per_s),
    ):
        if value is not None:
            assert math.exp(numbers_of(table[name])[place]) == pytest.approx(value, rel=2e-5)


def test_aircraft_that_cannot_carry_itself_is_no_number() -> None:
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    mission = missions.load_mission("rafz-july")
    axis = Axis("battery.mass_kg", np.array([3.0, 3000.0]))
    table = design_table(aircraft, mission, [axis])
    assert np.isnan(numbers_of(table["log_power_w"])).tolist() == [False, True]


def test_light_of_a_horizontal_model_is_kept_up_to_noon() -> None:
    aircraft = sizing.load_aircraft("atlantiksolar-as2")
    mission = missions.load_mission("rafz-july")
    table = light_table(aircraft, mission, sizing.SolarModel())
    power = numbers_of(table["power_w_per_m2"])
    assert table["mirrored"]
    assert power.shape == (len(table["latitudes_deg"]), len(table["days"]), 49)
    # The equator's day lasts twelve hours all year: the highest power is that at noon.
    equator = power[table["latitudes_deg"].index(0.0)]
    assert np.all(equator.argmax(axis=1) == 48)
    # No sun at the north pole in the first week of the year.
    assert_allclose(power[-1, 0], 0.0, atol=0.01)


def test_modules_become_one() -> None:
    parts = {
        "main.js": 'import { a as b, f } from "./one.js";\nconsole.log(f(b));\n',
        "one.js": 'import { c } from "./two.js";\nexport const a = c + 1;\n'
        "export function f(x) {\n  return 2 * x;\n}\n",
        "two.js": "export class D {}\nexport const c = 1;\n",
    }
    text = bundled(parts, "main.js")
    assert "import" not in text
    assert "export" not in text
    assert text.index("module_two =") < text.index("module_one =") < text.index("module_main =")
    assert "const { a: b, f } = module_one;" in text
    assert "return { a, f };" in text
    assert "return { D, c };" in text


@pytest.mark.parametrize("line", ['import x from "./y.js";', "export default 1;", "export { a };"])
def test_other_forms_of_modules_are_refused(line: str) -> None:
    with pytest.raises(ValueError, match=r"main\.js: a form of import or export"):
        bundled({"main.js": f"{line}\n"}, "main.js")
