"""Operating point of propeller, gear, motor, controller and wiring at thrust, airspeed and air."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.air import Air
from sizing.parameters import all_replaced
from sizing.propulsion.electric import Controller, Gear, Motor, MotorState
from sizing.propulsion.propeller import Propeller, tip_mach
from sizing.roots import bracketed_root
from sizing.smooth import Value
from solar.schema import Allowed, spell, spell_ends
from solar.types import BoolArray, FloatArray

_FASTEST_TIP_MACH = 0.95  # end of the search for a rotation
_SLOWEST_SHARE = 1e-3  # start of the search over its end
_WIRING_ROUNDS = 60  # of the voltage behind the wiring, to convergence
_AT_ONCE = 256  # points whose blade elements fit into the cache
_SIZES = ("diameter_m", "pitch_m")


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

    def _at(self, shape: tuple[int, ...], indices: slice) -> Propulsor:
        """Return the propulsors at indices of the flattened points of a shape."""

        def part_of(record: Any, names: Iterable[str], replaced_in: Any = all_replaced) -> Any:
            sizes: dict[str, Any] = {name: getattr(record, name, None) for name in names}
            arrays = {
                name: np.broadcast_to(value, shape).ravel()[indices]
                for name, value in sizes.items()
                if np.ndim(value)
            }
            return replaced_in(record, arrays) if arrays else record

        propeller = part_of(self.propeller, _SIZES, lambda part, sizes: replace(part, **sizes))
        gear, motor = (part_of(part, type(part).model_fields) for part in (self.gear, self.motor))
        return replace(self, propeller=propeller, gear=gear, motor=motor)


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
    return OperatingPoint(*_in_chunks(_points_in_row, propulsor, arrays))


def _in_chunks(
    function: Callable[..., tuple[Any, ...]], propulsor: Propulsor, arrays: Sequence[FloatArray]
) -> Iterator[Any]:
    """Yield the columns of a function in chunks of points whose blade elements fit into the cache.

    The function takes propulsor, thrust, airspeed, air and other arrays, in one dimension; the
    state of the air ends the arrays.
    """
    shape, flat, parts = arrays[0].shape, [np.ravel(array) for array in arrays], []
    for first in range(0, max(flat[0].size, 1), _AT_ONCE):
        indices = slice(first, first + _AT_ONCE)
        rows = [row[indices] for row in flat]
        thrust, v, *others = rows[:-4]
        parts.append(function(propulsor._at(shape, indices), thrust, v, Air(*rows[-4:]), *others))
    for columns in zip(*parts, strict=True):
        yield np.concatenate(columns).reshape(shape)


def shafts_at(
    propulsor: Propulsor, thrust_n: FloatArray, airspeed_m_per_s: Value, air: Air
) -> tuple[Any, ...]:
    """Return shafts at thrusts, of the broadcast shape of the arguments.

    Independent of the bus voltage: speed of rotation [1/s], power [W] and torque [N m] of the
    propeller's shaft, speed [rpm], torque [N m], current [A] and voltage [V] of the motor; NaN
    outside the propeller's data, for a reason in words.
    """
    arrays = np.broadcast_arrays(
        *(np.asarray(values, float) for values in (thrust_n, airspeed_m_per_s, *air))
    )
    return tuple(_in_chunks(_shafts, propulsor, arrays))


def _shafts(propulsor: Propulsor, thrust: FloatArray, v: FloatArray, air: Air) -> tuple[Any, ...]:
    """Return shafts as :func:`shafts_at`, in one dimension."""
    propeller, gear = propulsor.propeller, propulsor.gear
    n, reason = _rotation(propeller, thrust, v, air)
    power = propeller.coefficients(v, n, air).power
    shaft_w = power * air.density_kg_per_m3 * n**3 * propeller.diameter_m**5
    torque = shaft_w / (2.0 * np.pi * n)
    motor_rpm, motor_torque = 60.0 * n * gear.ratio, torque / (gear.ratio * gear.efficiency)
    motor = propulsor.motor.state(motor_rpm, motor_torque)
    return n, shaft_w, torque, motor_rpm, motor_torque, *motor, reason


def _points_in_row(
    propulsor: Propulsor, thrust: FloatArray, v: FloatArray, air: Air, bus: FloatArray
) -> OperatingPoint:
    """Return operating points, in one dimension."""
    gear, controller, d = propulsor.gear, propulsor.controller, propulsor.propeller.diameter_m
    shafts = _shafts(propulsor, thrust, v, air)
    n, shaft_w, torque, motor_rpm, motor_torque, *state, reason = shafts
    motor = MotorState(*state)
    motor_w = motor.current_a * motor.voltage_v
    inlet_v, needed_v = voltages_of_inlet(propulsor, motor, bus)
    inlet_w = controller.input_power_w(motor, inlet_v)
    wiring = wiring_efficiency(inlet_v, bus)
    bus_w = inlet_w / wiring
    mach = tip_mach(v, n, d, air)
    for wrong, text, digits, *values in (
        (
            mach > propulsor.maximum_tip_mach,
            "tip Mach number {} is above {}: a larger propeller turns slower",
            3,
            mach,
            np.full_like(bus, propulsor.maximum_tip_mach),
        ),
        (
            bus < needed_v,
            "bus voltage {} V is below {} V, which {} rpm of the motor need",
            4,
            bus,
            np.ceil(100.0 * needed_v) / 100.0,
            motor_rpm,
        ),
        _exceeded_limit(propulsor.motor.maximum_current_a, motor.current_a, "motor current {} A"),
        _exceeded_limit(propulsor.motor.maximum_power_w, motor_w, "motor power {} W"),
    ):
        for place in np.flatnonzero(wrong & (reason == "") & propulsor.limited):
            reason[place] = text.format(*(spell(column[place], digits) for column in values))
    good = np.where(reason == "", 1.0, np.nan)
    thrust_w = thrust * v
    return OperatingPoint(
        rotation_rpm=60.0 * n,
        motor_rpm=motor_rpm,
        tip_mach=mach,
        advance_ratio=v / (n * d),
        propeller_torque_nm=torque,
        motor_torque_nm=motor_torque,
        motor_current_a=motor.current_a,
        motor_voltage_v=motor.voltage_v,
        duty=good * controller.duty(motor, inlet_v),
        bus_current_a=good * bus_w / bus,
        bus_power_w=good * bus_w,
        thrust_power_w=thrust_w,
        propeller_efficiency=good * thrust_w / shaft_w,
        gear_efficiency=good * gear.efficiency,
        motor_efficiency=good * shaft_w / gear.efficiency / motor_w,
        controller_efficiency=good * motor_w / inlet_w,
        wiring_efficiency=good * wiring,
        efficiency=good * thrust_w / bus_w,
        reason=np.asarray(reason, dtype=np.str_),
    )


def _exceeded_limit(
    limit: Value | None, values: FloatArray, use: str
) -> tuple[BoolArray, str, int, FloatArray, FloatArray]:
    """Return where a limit of the motor is exceeded, the message's format, digits and values."""
    most = np.broadcast_to(np.asarray(np.inf if limit is None else limit), values.shape)
    return values > most, f"{use} is above {{}}{use[-2:]}, the motor's limit", 3, values, most


def voltages_of_inlet(
    propulsor: Propulsor, motor: MotorState, bus: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the voltage at the controller, and the least bus voltage that suffices [V].

    ``V = V_bus - R P(V) / V``; the duty is 1 at the least voltage.
    """
    resistance = propulsor.wiring_resistance_ohm
    least = motor.voltage_v + motor.current_a * propulsor.controller.resistance_ohm
    needed = least + resistance * propulsor.controller.input_power_w(motor, least) / least
    voltage = bus
    for _ in range(_WIRING_ROUNDS if resistance else 0):
        power = propulsor.controller.input_power_w(motor, voltage)
        voltage = np.maximum(bus - resistance * power / voltage, least)
    return np.asarray(voltage), np.asarray(needed)


def wiring_efficiency(inlet_v: FloatArray, bus_v: FloatArray) -> FloatArray:
    """Return the efficiency of the wiring [-]; at most 1 where the bus voltage is insufficient."""
    return np.asarray(np.minimum(inlet_v / bus_v, 1.0))


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
    each = np.repeat(np.arange(len(v)), propeller.trials)
    air_at = Air(*(values[each] for values in air))
    pull = _thrust(propeller.at(each), trial.ravel(), v[each], air_at).reshape(trial.shape)
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
