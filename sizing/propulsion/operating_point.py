"""Operating point of propeller, gear, motor, controller and wiring at thrust, airspeed and air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.air import Air
from sizing.propulsion.electric import Controller, Gear, Motor, MotorState
from sizing.propulsion.propeller import Propeller, tip_mach
from sizing.roots import bracketed_root
from sizing.smooth import Value
from solar.schema import Allowed, spell, spell_ends
from solar.types import BoolArray, FloatArray

_FASTEST_TIP_MACH = 0.95  # end of the search for a rotation
_SLOWEST_SHARE = 1e-3  # start of the search over its end
# Rounds of the voltage behind the wiring; each leaves at most a thousandth of the error.
_WIRING_ROUNDS = 5
_AT_ONCE = 256  # points whose blade elements fit into the cache
# Reasons of points beyond a limit, with the digits of their numbers; the first counts.
_REASONS = {
    "tip_mach": ("tip Mach number {} is above {}: a larger propeller turns slower", 3),
    "bus_voltage": ("bus voltage {1} V is below {0} V, which {2} rpm of the motor need", 4),
    "motor_current": ("motor current {} A is above {} A, the motor's limit", 3),
    "motor_power": ("motor power {} W is above {} W, the motor's limit", 3),
}


class Shaft(NamedTuple):
    """Propeller's shaft: speed of rotation [1/s] and power [W]; NaN for a reason in words."""

    rotation_per_s: FloatArray
    power_w: FloatArray
    reason: NDArray[np.object_]


class BehindShaft(NamedTuple):
    """Motor, controller and wiring behind a shaft, without limits of the parts.

    ``least_bus_v``: least bus voltage that suffices, at which the duty is 1 [V]. ``inlet_v``,
    ``inlet_w``: at the controller.
    """

    motor_rpm: Value
    motor_torque_nm: Value
    motor: MotorState
    least_bus_v: Value
    inlet_v: Value
    inlet_w: Value
    bus_w: Value


@dataclass(frozen=True)
class Propulsor:
    """Propeller with its gear, motor, controller and wiring.

    Diameter, pitch, gear ratio and constants of the motor may be arrays that broadcast with the
    operating points.

    Attributes
    ----------
    propeller : PropellerTable or BladeElementPropeller
    motor : Motor
    controller : Controller
    gear : Gear
        Ratio and efficiency 1 by default.
    wiring_resistance_ohm : float
        From the bus to the controller and back [ohm].
    maximum_tip_mach : float
        Largest Mach number of the tips [-]; the propeller models are incompressible.
    limited : bool
        Whether the limits of the parts make operating points infeasible.

    Raises
    ------
    ValueError
        For a resistance below 0 or a Mach number that is not between 0 and 1.
    """

    propeller: Propeller
    motor: Motor
    controller: Controller
    gear: Gear = Gear()  # noqa: RUF009 (frozen)
    wiring_resistance_ohm: float = 0.0
    maximum_tip_mach: float = 0.7
    limited: bool = True

    def __post_init__(self) -> None:
        """Check resistance and Mach number."""
        Allowed(0.0, below=True).check("wiring_resistance_ohm", self.wiring_resistance_ohm)
        fraction = Allowed(0.0, 1.0, above=True, below=True)
        fraction.check("maximum_tip_mach", self.maximum_tip_mach)

    def behind_shaft(self, shaft: Shaft, bus_v: Value) -> BehindShaft:
        """Return motor, controller and wiring at a bus voltage [V].

        ``V = V_bus - R P(V) / V`` at the controller, solved for V at a known P; half of the bus
        voltage is left at the largest power that the wiring passes.

        Parameters
        ----------
        shaft : Shaft
            Rotation and power of the propeller's shaft.
        bus_v : float or array
            Voltage of the bus, which broadcasts with them [V].

        Returns
        -------
        BehindShaft
            Of the shape of both.
        """
        gear, controller, resistance = self.gear, self.controller, self.wiring_resistance_ohm
        rpm = 60.0 * shaft.rotation_per_s * gear.ratio
        torque = shaft.power_w / (2.0 * np.pi * shaft.rotation_per_s)
        torque = torque / (gear.ratio * gear.efficiency)
        motor = self.motor.state(rpm, torque)
        least_v = motor.voltage_v + motor.current_a * controller.resistance_ohm
        wires_v = resistance * controller.input_power_w(motor, least_v) / least_v
        inlet_v, inlet_w = bus_v, controller.input_power_w(motor, bus_v)
        for _ in range(_WIRING_ROUNDS if resistance else 0):
            square = np.maximum(bus_v**2 - 4.0 * resistance * inlet_w, 0.0)
            inlet_v = (bus_v + np.sqrt(square)) / 2.0
            inlet_w = controller.input_power_w(motor, inlet_v)
        bus_w = inlet_w * bus_v / inlet_v
        return BehindShaft(rpm, torque, motor, least_v + wires_v, inlet_v, inlet_w, bus_w)

    def used_and_limits(
        self, shaft: Shaft, behind: BehindShaft, airspeed_m_per_s: Value, air: Air, bus_v: Value
    ) -> dict[str, tuple[Value, Value]]:
        """Return what the parts use of every limit that they have, and the limit.

        Parameters
        ----------
        shaft : Shaft
            Rotation and power of the propeller's shaft.
        behind : BehindShaft
            Motor, controller and wiring at this shaft.
        airspeed_m_per_s : float or array
            Airspeed [m/s].
        air : Air
            State of the air.
        bus_v : float or array
            Voltage of the bus [V].

        Returns
        -------
        dict
            By the name of the limit what is used, and the limit, in its unit.
        """
        (current_a, voltage_v), motor = behind.motor, self.motor
        mach = tip_mach(airspeed_m_per_s, shaft.rotation_per_s, self.propeller.diameter_m, air)
        every = {
            "bus_voltage": (behind.least_bus_v, bus_v),
            "tip_mach": (mach, self.maximum_tip_mach),
            "motor_current": (current_a, motor.maximum_current_a),
            "motor_power": (current_a * voltage_v, motor.maximum_power_w),
        }
        return {name: pair for name, pair in every.items() if pair[1] is not None}


class OperatingPoint(NamedTuple):
    """State of a propulsor at operating points, in arrays of their shape.

    Attributes
    ----------
    rotation_rpm, motor_rpm
        Speeds of propeller and motor [rpm].
    tip_mach, advance_ratio
        Of the propeller [-].
    propeller_torque_nm, motor_torque_nm
        At the two shafts [N m].
    motor_current_a, motor_voltage_v
        Mean current and voltage at the motor's terminals [A, V].
    duty
        Of the controller [-].
    bus_current_a, bus_power_w
        Delivered by the bus [A, W].
    thrust_power_w
        Thrust times airspeed [W].
    propeller_efficiency, gear_efficiency, motor_efficiency, controller_efficiency, \
wiring_efficiency, efficiency
        Of every link, and their product: thrust power over bus power [-].
    reason
        Why the point is infeasible, with the violated limit; empty where it is feasible. Duty, bus
        current, bus power and efficiencies are NaN at infeasible points, everything outside the
        propeller's data.
    """

    rotation_rpm: FloatArray
    motor_rpm: FloatArray
    tip_mach: FloatArray
    advance_ratio: FloatArray
    propeller_torque_nm: FloatArray
    motor_torque_nm: FloatArray
    motor_current_a: FloatArray
    motor_voltage_v: FloatArray
    duty: FloatArray
    bus_current_a: FloatArray
    bus_power_w: FloatArray
    thrust_power_w: FloatArray
    propeller_efficiency: FloatArray
    gear_efficiency: FloatArray
    motor_efficiency: FloatArray
    controller_efficiency: FloatArray
    wiring_efficiency: FloatArray
    efficiency: FloatArray
    reason: NDArray[np.str_]

    @property
    def bus_voltage_v(self) -> FloatArray:
        """Voltage of the bus [V]."""
        return self.bus_power_w / self.bus_current_a

    @property
    def feasible(self) -> BoolArray:
        """True where the point is feasible."""
        return np.asarray(self.reason == "")

    def budget_w(self) -> dict[str, FloatArray]:
        """Return thrust power, and losses from propeller to wiring [W]; their sum is bus power."""
        shares, after = {"thrust": self.thrust_power_w}, self.bus_power_w
        for name in ("wiring", "controller", "motor", "gear", "propeller"):
            before, after = after, after * getattr(self, f"{name}_efficiency")
            shares[name] = before - after
        return {name: shares[name] for name in ("thrust", *reversed(list(shares)[1:]))}


def operating_point(
    propulsor: Propulsor,
    thrust_n: ArrayLike,
    airspeed_m_per_s: ArrayLike,
    air: Air,
    bus_voltage_v: ArrayLike,
) -> OperatingPoint:
    """Return speed of rotation, currents, voltages and efficiencies at a thrust.

    The slowest rotation with this thrust gives the torque, ``Q = C_P rho n^2 D^5 / (2 pi)``; the
    gear passes ``Q / (g eta_g)`` on to the motor, which turns ``g`` times as fast; motor and
    controller give current, voltage and power (:class:`Motor`, :class:`Controller`); the wiring
    dissipates ``I^2 R``.

    Parameters
    ----------
    propulsor : Propulsor
    thrust_n : array_like
        Thrust of one propulsor, above 0 [N].
    airspeed_m_per_s : array_like
        True airspeed, 0 or more [m/s].
    air : Air
        For instance of :func:`missions.standard_air`.
    bus_voltage_v : array_like
        Voltage of the bus, above 0 [V].

    Returns
    -------
    OperatingPoint
        Of the broadcast shape of the arguments; infeasible points have a reason.

    Raises
    ------
    ValueError
        For thrusts, airspeeds or voltages out of range.
    """
    arrays = np.broadcast_arrays(
        *(np.asarray(values, float) for values in (thrust_n, airspeed_m_per_s, bus_voltage_v, *air))
    )
    for name, values in (
        ("thrust_n", arrays[0]),
        ("bus_voltage_v", arrays[2]),
        ("the density of the air", arrays[5]),
    ):
        Allowed(0.0, above=True, below=True).check(name, values)
    Allowed(0.0, below=True).check("airspeed_m_per_s", arrays[1])
    thrust, v, bus_v, *state = arrays
    at = Air(*state)
    shaft = shaft_at(propulsor.propeller, thrust, v, at)
    return point_behind(propulsor, shaft, v, at, bus_v, thrust)


def shaft_at(propeller: Propeller, thrust_n: Value, airspeed_m_per_s: Value, air: Air) -> Shaft:
    """Return the shaft at thrusts [N], of the broadcast shape of the arguments.

    In chunks of points whose blade elements fit into the cache.
    """
    arrays = np.broadcast_arrays(
        *(np.asarray(values, float) for values in (thrust_n, airspeed_m_per_s, *air))
    )
    shape, flat, parts = arrays[0].shape, [np.ravel(array) for array in arrays], []
    for first in range(0, max(flat[0].size, 1), _AT_ONCE):
        indices = slice(first, first + _AT_ONCE)
        thrust, v, *state = (row[indices] for row in flat)
        there, here = Air(*state), propeller.at(indices, shape)
        n, reason = _rotation(here, thrust, v, there)
        power = here.coefficients(v, n, there).power
        parts.append((n, power * there.density_kg_per_m3 * n**3 * here.diameter_m**5, reason))
    return Shaft(*(np.concatenate(column).reshape(shape) for column in zip(*parts, strict=True)))


def point_behind(
    propulsor: Propulsor,
    shaft: Shaft,
    airspeed_m_per_s: FloatArray,
    air: Air,
    bus_v: FloatArray,
    thrust_n: FloatArray,
) -> OperatingPoint:
    """Return the operating points of shafts at thrusts; all arguments broadcast."""
    n, shaft_w, reason = shaft
    gear, v, behind = propulsor.gear, airspeed_m_per_s, propulsor.behind_shaft(shaft, bus_v)
    motor, inlet_v, inlet_w = behind.motor, behind.inlet_v, behind.inlet_w
    used = propulsor.used_and_limits(shaft, behind, v, air, bus_v)
    shape = np.broadcast_shapes(np.shape(inlet_w), np.shape(bus_v))
    reason = np.array(np.broadcast_to(reason, shape))
    for name, (text, digits) in _REASONS.items() if propulsor.limited else ():
        if name not in used:
            continue
        value, most = used[name]
        if name == "bus_voltage":  # as it is spelled, it suffices
            value = np.where(value > most, np.ceil(100.0 * value) / 100.0, value)
        columns = np.broadcast_arrays(value, most, behind.motor_rpm, reason)[:3]
        for place in map(tuple, np.argwhere((columns[0] > columns[1]) & (reason == ""))):
            numbers = (spell(float(column[place]), digits) for column in columns)
            reason[place] = text.format(*numbers)
    good, motor_w = np.where(reason == "", 1.0, np.nan), motor.current_a * motor.voltage_v
    thrust_w, d = thrust_n * v, propulsor.propeller.diameter_m
    point = OperatingPoint(
        rotation_rpm=60.0 * n,
        motor_rpm=behind.motor_rpm,
        tip_mach=used["tip_mach"][0],
        advance_ratio=v / (n * d),
        propeller_torque_nm=shaft_w / (2.0 * np.pi * n),
        motor_torque_nm=behind.motor_torque_nm,
        motor_current_a=motor.current_a,
        motor_voltage_v=motor.voltage_v,
        duty=good * propulsor.controller.duty(motor, inlet_v),
        bus_current_a=good * behind.bus_w / bus_v,
        bus_power_w=good * behind.bus_w,
        thrust_power_w=thrust_w,
        propeller_efficiency=good * thrust_w / shaft_w,
        gear_efficiency=good * gear.efficiency,
        motor_efficiency=good * shaft_w / gear.efficiency / motor_w,
        controller_efficiency=good * motor_w / inlet_w,
        wiring_efficiency=good * inlet_v / bus_v,
        efficiency=good * thrust_w / behind.bus_w,
        reason=np.asarray(reason, dtype=np.str_),
    )
    return OperatingPoint(*np.broadcast_arrays(*point))


def _rotation(
    propeller: Propeller, thrust: FloatArray, v: FloatArray, air: Air
) -> tuple[FloatArray, NDArray[np.object_]]:
    """Return the slowest rotation [1/s] of a thrust; NaN with a reason where there is none.

    Speeds between the ends of the propeller's data are tried, until two bracket the thrust.
    """
    d = propeller.diameter_m
    (least_j, largest_j), (slowest, fastest) = propeller.limits()
    per_mach = tip_mach(0.0, 1.0, d, air)
    upper = np.minimum(fastest, _FASTEST_TIP_MACH / per_mach)
    if least_j > 0.0:
        upper = np.where(v > 0.0, np.minimum(upper, v / (least_j * d)), upper)
    lower = np.maximum(np.maximum(slowest, v / (largest_j * d)), _SLOWEST_SHARE * upper)
    lower = np.minimum(lower, upper)
    trial = lower[:, None] * (upper / lower)[:, None] ** np.linspace(0.0, 1.0, propeller.trials)
    here = Air(*(values[:, None] for values in air))
    pull = _thrust(propeller.at(np.s_[:, None]), trial, v[:, None], here)
    crosses = (pull[:, :-1] <= thrust[:, None]) & (pull[:, 1:] >= thrust[:, None])
    crossing = np.flatnonzero(crosses.any(axis=1))
    first = np.argmax(crosses[crossing], axis=1)
    ends = trial[crossing, first], trial[crossing, first + 1]
    n = np.full(len(v), np.nan)
    if crossing.size:
        pulling = propeller.at(crossing)
        pulled, speed, *state = (values[crossing] for values in (thrust, v, *air))
        n[crossing] = bracketed_root(
            lambda turns: _thrust(pulling, turns, speed, Air(*state)) - pulled, *ends
        )
    reason = np.full(len(v), "", dtype=object)
    for place in np.flatnonzero(np.isnan(n)):
        reason[place] = _no_rotation(thrust[place], v[place], pull[place], propeller.at(int(place)))
    return n, reason


def _thrust(propeller: Propeller, rotation: FloatArray, v: FloatArray, air: Air) -> FloatArray:
    """Return the thrust at a speed of rotation [N]; NaN outside the propeller's data."""
    coefficient = propeller.coefficients(v, rotation, air).thrust
    return np.asarray(coefficient * air.density_kg_per_m3 * rotation**2 * propeller.diameter_m**4)


def _no_rotation(thrust: float, v: float, pull: FloatArray, propeller: Propeller) -> str:
    """Return why no speed of rotation has this thrust, with the range of the data."""
    advance, rotation = propeller.limits()
    data = f"the propeller's data (J from {spell_ends(advance, 3)}"
    if rotation[1] < np.inf:
        data += f" and from {spell_ends((60.0 * turns for turns in rotation), 4)} rpm"
    data += ")"
    known, speed, pulled = pull[np.isfinite(pull)], f"{spell(v, 3)} m/s", f"{spell(thrust, 3)} N"
    if not known.size:
        return f"an airspeed of {speed} lies outside {data}"
    if known.max() <= 0.0:
        return f"the propeller brakes at {speed}, at every speed of rotation in {data}"
    if known.min() <= thrust <= known.max():
        return f"thrust {pulled} at {speed} lies in a gap of {data}"
    if thrust > known.max():
        most = f"{spell(known.max(), 3)} N, the most at {speed} in {data}"
        return f"thrust {pulled} is above {most}"
    return f"thrust {pulled} is below {spell(known.min(), 3)} N, the least at {speed} in {data}"
