import numpy as np
import pytest

from missions.files.overrides import with_values
from missions.library import load_mission
from sizing.day.light import SolarModel, solar_day
from sizing.library import load_aircraft
from studies.models.component_efficiencies import component_efficiencies

AS2 = load_aircraft("atlantiksolar-as2")


@pytest.mark.parametrize(
    "margins",
    [
        {},
        {"solar_model_sigmas": 1.5},
        {"clearness_minimum": 0.7},
        {"solar_model_sigmas": 1.0, "clearness_minimum": 0.8},
    ],
)
def test_module_power_is_that_of_every_other_study(margins):
    """The same light is believed everywhere, uncertainty margins taken off."""
    mission = with_values(load_mission("rafz-loiter"), {"uncertainty_margins": margins})
    data = component_efficiencies(AS2, mission)
    day = solar_day(AS2, mission, SolarModel("FM"))
    daylight = np.isin(day.time_h, data["time"].to_numpy())
    # The same formulas; numpy may sum the blocks of one and the other in another order.
    np.testing.assert_allclose(
        data["specific_power"].to_numpy(), day.specific_power_w_per_m2[0][daylight], rtol=1e-12
    )
