"""What a mission asks of its aircraft beside level flight, and how much worse all may turn out."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict

from solar.schema import Fraction, NonNegativeReal, Record, wrong_value


class Payload(Record):
    """What the aircraft carries for its mission."""

    mass_kg: NonNegativeReal = 0.0
    power_w: NonNegativeReal = 0.0


class Turbulence(Record):
    """Extra propulsion power relative to level flight.

    ``all_day`` acts at every hour; ``thermal`` is added by day: nothing at sunrise and sunset,
    the full value at solar noon, linear in between.
    """

    all_day: Annotated[float, Strict(), Field(ge=0.0, le=5.0)] = 0.0
    thermal: Annotated[float, Strict(), Field(ge=0.0, le=5.0)] = 0.0


class UncertaintyMargins(Record):
    """What may turn out worse than assumed: performance is computed at the worst of every margin.

    Less sun and less capacity never help, so that the worst case of all combinations is the one
    with the worst of each.

    ``solar_model_sigmas`` is how many RMS errors of the solar power model are taken off the power;
    ``clearness_minimum`` replaces a higher clearness; ``battery_capacity`` is the fraction of the
    capacity that is left at the end of the battery's life.
    """

    solar_model_sigmas: Annotated[float, Strict(), Field(ge=0.0, le=4.0)] = 0.0
    clearness_minimum: Fraction | None = None
    battery_capacity: Fraction = 1.0

    @property
    def given(self) -> bool:
        """Whether there is any margin."""
        return self != UncertaintyMargins()

    def check(self, clearness: float) -> None:
        """Refuse a worst clearness above the one that is assumed."""
        lowest = self.clearness_minimum
        if lowest is not None and lowest > clearness:
            raise wrong_value(
                "uncertainty_margins.clearness_minimum",
                f"must be at most the mission's clearness of {clearness:g} (got {lowest:g})",
            )

    def worst_clearness(self, clearness: float) -> float:
        """Clearness at the worst of its margin [-]."""
        return clearness if self.clearness_minimum is None else self.clearness_minimum

    def solar_factor(self, rms_relative: float) -> float:
        """Factor on the solar power of a model with this RMS error."""
        return max(1.0 - self.solar_model_sigmas * rms_relative, 0.0)
