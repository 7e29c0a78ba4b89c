"""Measured and modelled solar power, load and charge of a flight.

Each channel predicts from an aircraft alone, given what else was logged: the charge from the
*measured* power and load, so that no error of one model is taken for another's.
"""

from __future__ import annotations

from collections.abc import Callable

from sizing.aircraft import Aircraft
from studies.fitting.channels.battery import charge_channel, load_channel
from studies.fitting.channels.bins import BIN_S
from studies.fitting.channels.channel import Channel, Flown
from studies.fitting.channels.solar import solar_channel
from studies.fitting.parameters import ChannelName

_FEWEST_BINS = 12  # an hour


def channels(
    flown: Flown, aircraft: Aircraft, light_sigma: float
) -> tuple[dict[ChannelName, Channel], list[str]]:
    """Channels that a log has, and why it has no others."""
    made_channels: dict[ChannelName, Channel] = {}
    missing = []
    makers: dict[ChannelName, Callable[[], Channel | str]] = {
        "solar": lambda: solar_channel(flown, aircraft, light_sigma),
        "load": lambda: load_channel(flown),
        "charge": lambda: charge_channel(flown),
    }
    for name, make in makers.items():
        made = make()
        if isinstance(made, str):
            missing.append(f"{name}: {made}")
        elif len(made.measured) < _FEWEST_BINS:
            missing.append(
                f"{name}: {len(made.measured)} means over {BIN_S / 60:g} min are too few"
            )
        else:
            made_channels[name] = made
    return made_channels, missing
