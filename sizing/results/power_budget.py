"""Where the electric power of level flight goes: from the air to the bus."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, level_point
from sizing.propulsion.chain import LINKS, OperatingPointPropulsion
from sizing.results.records import finite

if TYPE_CHECKING:
    from sizing.propulsion.operating_point import OperatingPoint


# Key of every row, and its words.
_SHOWN = 1e-5  # of the chain: the fourth digit of what is printed
_ROWS = {
    "aerodynamic_w": "drag of level flight",
    **{f"{link}_loss_w": f"lost in the {link}" for link in reversed(LINKS)},
    "propulsion_w": "propulsion in level flight (measured)",
    "turbulence_w": "turbulence",
    "avionics_w": "avionics",
    "payload_w": "payload",
    "supply_loss_w": "lost in the power supply",
    "heater_w": "heater of the battery",
}
# Words that are long in a sentence.
_SHORT = {
    one: one.removeprefix("lost in the ")
    .removesuffix(" of level flight")
    .removesuffix(" in level flight (measured)")
    for one in _ROWS.values()
}


@dataclass(frozen=True)
class PowerBudget:
    """Power of level flight, with the turbulence of all hours.

    ``watts``: by the keys of its rows [W], which add up to ``bus_w``; a measured aircraft has
    ``propulsion_w`` instead of drag and losses. ``efficiencies``: of the links and of the chain
    [-], empty for a measured aircraft. ``point``: of one propulsor, where the aircraft's file says
    what it is made of. ``assumed``: efficiency of the chain that the design was found with [-].
    """

    watts: dict[str, float]
    efficiencies: dict[str, float]
    point: OperatingPoint | None
    assumed: float | None

    @property
    def bus_w(self) -> float:
        """Sum of the rows [W]."""
        return sum(self.watts.values())

    def rows(self) -> tuple[tuple[str, float], ...]:
        """Rows in words, without those of nothing."""
        return tuple((_ROWS[key], one) for key, one in self.watts.items() if one > 1e-9)

    def note(self) -> str:
        """What the efficiencies are."""
        if not self.efficiencies:
            return "Only the whole power of a measured aircraft is known, not the share of drag."
        chain = f"From battery to thrust: {100.0 * self.efficiencies['chain']:.1f} %"
        if self.point is None:
            return f"{chain} by constants of the file (assumed)."
        point, off = self.point, (self.assumed or 0.0) - self.efficiencies["chain"]
        rest = f"; the optimiser's efficiency is {off:+.1e} off" if abs(off) > _SHOWN else ""
        return (
            f"{chain} at the operating point: propeller {float(point.rotation_rpm):.0f} rpm, "
            f"motor {float(point.motor_current_a):.2f} A, duty {float(point.duty):.2f} of "
            f"{float(point.bus_power_w / point.bus_current_a):.1f} V{rest}."
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready; null for what is not known of a measured aircraft."""
        point = None
        if self.point is not None:
            point = {k: v if k == "reason" else finite(v) for k, v in asdict(self.point).items()}
            del point["reason"]
        return {
            **{key: self.watts.get(key) for key in _ROWS},
            "bus_w": self.bus_w,
            "efficiencies": self.efficiencies or None,
            "assumed_efficiency": self.assumed,
            "operating_point": point,
        }


def power_budget(aircraft: Aircraft, mission: Mission, design: Design) -> PowerBudget:
    """Power budget of a design in level flight on a mission.

    The design may be an optimum with the aircraft's technology. An operating point is computed
    anew, at the design's mass.
    """
    level_w, chain, point = float(design.propulsion_power_w), design.chain, None
    watts, efficiencies = {"propulsion_w": level_w}, {}
    if chain is not None:
        thrust_w = level_w * float(chain.efficiency)
        efficiencies = {link: getattr(chain, f"{link}_efficiency") for link in LINKS}
        if isinstance(getattr(aircraft.airframe, "propulsion", None), OperatingPointPropulsion):
            point = level_point(aircraft, mission, design)
            efficiencies = {k: float(getattr(point, f"{v}_efficiency")) for k, v in LINKS.items()}
        efficiencies = {k: 1.0 if v is None else float(v) for k, v in efficiencies.items()}
        watts, after = {"aerodynamic_w": thrust_w}, thrust_w
        for link in reversed(LINKS):
            before = after / efficiencies[link]
            watts[f"{link}_loss_w"], after = before - after, before
        efficiencies["chain"], level_w = thrust_w / after, after
    power, chosen = aircraft.power, design.variables.payload_power_w
    payload_w = mission.payload.power_w if chosen is None else float(chosen)
    consumers_w = power.avionics_w + payload_w
    supplied_w = consumers_w / power.supply_efficiency
    watts |= {
        "turbulence_w": level_w * mission.turbulence.all_day,
        "avionics_w": power.avionics_w,
        "payload_w": payload_w,
        "supply_loss_w": supplied_w - consumers_w,
        "heater_w": float(design.constant_power_w) - supplied_w,
    }
    assumed = None if chain is None else float(chain.efficiency)
    return PowerBudget(watts, efficiencies, point, assumed)


def power_line(budget: PowerBudget, mission: Mission) -> str:
    """Power budget in a sentence; faster flight against the wind is not part of it."""
    parts = [f"{_SHORT.get(one, one)} {watts:.2f} W" for one, watts in budget.rows()]
    slow = " at its own airspeed" if mission.holds_station else ""
    return f"power in level flight{slow}, {budget.bus_w:.2f} W: {', '.join(parts)}. {budget.note()}"
