"""Solar power models against a flight log: errors, and what looks wrong in the flight.

Errors are those of Oettershagen's report on solar power models, section 4: modelled minus measured
power, negative where the model underestimates; relative to the mean measured power; RMS and maximum
of data that passed a two-sided moving average. The anomalies are sought by rules, whose thresholds
are the constants below; ``docs/verify.md`` gives the reason of each.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, standard_air
from missions.flight_log import BoolArray, FlightLog, Gap, IntArray
from missions.mission import Mission
from missions.problems import file_error
from sizing.aircraft import Aircraft
from solar.almanac import SECONDS_PER_DAY, sun_position
from solar.attitude import direction_cosines
from solar.clearsky import Irradiance, clear_sky
from solar.full_model import ModulePower, full_model, verification_model
from solar.geometry import ModuleGeometry
from solar.names import ModelName
from solar.power import conceptual_analysis_model, conceptual_design_model
from solar.sun import FloatArray

ShadedArea: TypeAlias = Callable[[FloatArray], FloatArray]
"""Shaded area of every module surface [m2] from sun vectors in body axes."""

Kind = Literal["mppt_not_tracking", "battery_full", "shading", "side_bias", "missing_data"]
Severity = Literal["minor", "moderate", "major"]

WINDOW_SEMI, DAY_SEMI = 2, 800  # samples; the report's filters

# Low-light tracking: irradiance on the modules below which trackers are known to fail, the share
# of the modelled power that must be missing, and the same in rated power and in noise.
LOW_LIGHT_W_PER_M2 = 250.0
LOW_LIGHT_DEFICIT, LOW_LIGHT_DEFICIT_RATED, LOW_LIGHT_SIGMAS = 0.2, 0.01, 5.0
LOW_LIGHT_SHARE, LOW_LIGHT_LEAST_S = 0.1, 30.0
VOLTAGE_OFF, VOLTAGE_SHARE = 0.05, 0.3

# Limited charging: load of the modules from which power is judged, share of it that is left, with
# charge and attitude logged and without one of them, and charge that counts as nearly full.
BRIGHT = 0.25
LIMITED, LIMITED_UNSURE, UNLIMITED = 0.90, 0.75, 0.97
NEAR_FULL = 0.85
LIMITED_LEAST_S = 120.0
SMOOTH_S = 60.0
LOAD_MATCH = 0.1
LEAST_JUDGED = 0.2  # share of the samples around one that must not be low light

# Shading: shaded share of the modules, least loss in modelled power, rated power and its error.
SHADED_SHARE, SHADING_LOSS, SHADING_LOSS_RATED, SHADING_T = 0.01, 0.02, 0.005, 4.0
SHADING_OF_EXPECTED = 0.2

# Bias by sun side: least difference, its significance, blocks in which it must have one sign.
SIDE_BIAS, SIDE_T, SIDE_SAME_SIGN, SIDE_BLOCK_S = 0.03, 5.0, 0.8, 1200.0
SIDE_ELEVATIONS_DEG = (10.0, 75.0)

_SIDES = ("front", "right", "rear", "left")
_CHUNK = 16_384
_MERGE_S = 600.0
_NEAR_S = 5.0
_WINDOW = re.compile(r"(?:(\d{4}-\d\d-\d\d)@)?(\d+(?:\.\d*)?):(\d+(?:\.\d*)?)")


# ---- Records


@dataclass(frozen=True)
class Detail:
    """What the Full Model says beside the power, averaged over the surfaces by area.

    Angles in degrees, temperatures in degrees Celsius, irradiance on the modules in W/m2; relative
    efficiencies. ``shaded_m2`` is the shaded module area, ``shading_loss_w`` the power that the
    shadow takes if direct light is lost in proportion; both are None without a tail.
    """

    incidence_deg: FloatArray
    irradiance_w_per_m2: FloatArray
    module_efficiency: FloatArray
    incidence_efficiency: FloatArray
    low_light_efficiency: FloatArray
    temperature_efficiency: FloatArray
    mppt_efficiency: FloatArray
    module_temperature_c: FloatArray
    shaded_m2: FloatArray | None
    shading_loss_w: FloatArray | None


@dataclass(frozen=True)
class Samples:
    """Samples of a log with the sun above the horizon, and all models on them.

    Attributes
    ----------
    index : ndarray of int
        Their places in the log.
    time_s, time_solar_h : ndarray
        Universal time [s since 1970] and true solar time [h].
    solar_day : ndarray of int
        Day by local solar time, days since 1970-01-01.
    run : ndarray of int
        Number of the uninterrupted stretch; neither gap nor night lies within one.
    elevation_deg, bearing_deg : ndarray
        The sun's elevation, and its bearing from the nose, clockwise, 0 to 360; the latter zero
        without attitude.
    measured_w : ndarray
        Measured power.
    modelled_w : mapping
        Power of each model that could be computed.
    detail : Detail or None
        More of the Full Model, if that could be computed.
    """

    index: IntArray
    time_s: FloatArray
    time_solar_h: FloatArray
    solar_day: IntArray
    run: IntArray
    elevation_deg: FloatArray
    bearing_deg: FloatArray
    measured_w: FloatArray
    modelled_w: Mapping[ModelName, FloatArray]
    detail: Detail | None


@dataclass(frozen=True)
class Window:
    """Period of solar time [h], on every day or on one (days since 1970-01-01)."""

    start_h: float
    end_h: float
    day: int | None = None

    @property
    def label(self) -> str:
        """Readable name."""
        hours = f"{self.start_h:g} to {self.end_h:g} h"
        return hours if self.day is None else f"{_date(self.day)}, {hours}"


@dataclass(frozen=True)
class ModelErrors:
    """Errors of one model [W]: average, RMS and largest; relative ones by ``measured_mean_w``."""

    modelled_mean_w: float
    measured_mean_w: float
    average_w: float
    rms_w: float
    maximum_w: float

    def relative(self, error_w: float) -> float | None:
        """Error over the mean measured power, none if nothing was measured."""
        return error_w / self.measured_mean_w if self.measured_mean_w > 0.0 else None


@dataclass(frozen=True)
class Section:
    """Errors over one window or day; ``excluded`` samples are not in them."""

    label: str
    start_s: float
    end_s: float
    samples: int
    excluded: int
    semi_window: int
    errors: Mapping[ModelName, ModelErrors]


@dataclass(frozen=True)
class Anomaly:
    """Something that looks wrong in the flight.

    ``lost_wh`` is the energy between model and measurement in it, zero if that means nothing.
    """

    kind: Kind
    start_s: float
    end_s: float
    severity: Severity
    evidence: str
    affected_s: float
    lost_wh: float


@dataclass(frozen=True)
class Verification:
    """Everything that a verification found."""

    aircraft: str
    mission: str
    log: FlightLog
    samples: Samples
    excluded: BoolArray
    windows: tuple[Section, ...]
    window_masks: tuple[BoolArray, ...]
    days: tuple[Section, ...]
    day_semi: int
    window_semi: int
    anomalies: tuple[Anomaly, ...]
    notes: tuple[str, ...]


def parse_window(text: str) -> Window:
    """Read a window ``5.71:5.79``, or ``2015-07-01@5.71:5.79`` of one day.

    Raises
    ------
    ValueError
        If the text is no such window.
    """
    match = _WINDOW.fullmatch(text.strip())
    form = "a:b in solar hours, for instance 5.71:5.79 or 2015-07-01@5.71:5.79"
    if match is None:
        raise ValueError(f"must be {form} (got {text!r})")
    start, end = float(match[2]), float(match[3])
    if not start < end <= 24.0:
        raise ValueError(f"must be {form}, a below b and both from 0 to 24 (got {text!r})")
    if match[1] is None:
        return Window(start, end)
    try:
        date = datetime.date.fromisoformat(match[1])
    except ValueError:
        raise ValueError(f"there is no date {match[1]}") from None
    return Window(start, end, (date - datetime.date(1970, 1, 1)).days)


def verify(
    log: FlightLog,
    aircraft: Aircraft,
    mission: Mission,
    *,
    windows: Sequence[Window] = (),
    semi_window: int | None = None,
    shading: ShadedArea | None = None,
) -> Verification:
    """Compare all models with a log and look for anomalies.

    Parameters
    ----------
    log : FlightLog
        The flight.
    aircraft : Aircraft
        Its modules; VM and FM need their geometry.
    mission : Mission
        Clearness, and temperatures that the log does not have.
    windows : sequence of Window
        Periods to report on apart from the days.
    semi_window : int, optional
        Samples on either side in the moving average; 2 in windows and 800 over days if not given.
    shading : ShadedArea, optional
        Shaded area instead of that of the aircraft's own tail.

    Raises
    ------
    InputError
        If the sun never rises in the log, or a window has no sample.
    """
    geometry, reasons = _geometry(log, aircraft)
    shade = shading
    if shade is None and geometry is not None:
        shade, reason = _tail_shading(aircraft, geometry)
        reasons += [reason] if reason else []
    samples, sources = _samples(log, aircraft, mission, geometry, shade)
    scene = _Scene.of(log, samples, aircraft)
    full, limited = _battery_full(scene)
    found = [*full, *_other_anomalies(scene, limited)]
    masks = tuple(_in_window(samples, window) for window in windows)
    for window, mask in zip(windows, masks, strict=True):
        if not mask.any():
            message = f"no sample with the sun up lies in the window {window.label} (solar time)"
            raise file_error(log.source, f"{message}; allowed: {_solar_span(samples)}")
    window_semi = WINDOW_SEMI if semi_window is None else semi_window
    day_semi = DAY_SEMI if semi_window is None else semi_window
    return Verification(
        aircraft=aircraft.name,
        mission=mission.name,
        log=log,
        samples=samples,
        excluded=limited,
        windows=_sections(
            samples, limited, window_semi, zip([w.label for w in windows], masks, strict=True)
        ),
        window_masks=masks,
        days=_sections(samples, limited, day_semi, day_masks(samples)),
        day_semi=day_semi,
        window_semi=window_semi,
        anomalies=tuple(sorted(found, key=lambda a: (a.start_s, a.kind))),
        notes=(*log.notes, *reasons, *sources),
    )


# ---- Models


def day_of_year(time_s: FloatArray) -> FloatArray:
    """Fractional day of year, 1.0 at the start of 1 January (UTC)."""
    instants = np.asarray(time_s).astype("datetime64[s]")
    years = instants.astype("datetime64[Y]").astype("datetime64[s]")
    return np.asarray(1.0 + (np.asarray(time_s) - years.astype(np.int64)) / SECONDS_PER_DAY, float)


def _geometry(log: FlightLog, aircraft: Aircraft) -> tuple[ModuleGeometry | None, list[str]]:
    """Module geometry if VM and FM can be computed, else why they cannot."""
    without = "VM and FM are not computed"
    if log.attitude is None:
        return None, [f"{without}: the log has no attitude (roll_deg, pitch_deg, yaw_deg)"]
    if aircraft.modules.geometry is None:
        return None, [f"{without}: {aircraft.name} has no modules.geometry"]
    return aircraft.modules.geometry, []


def _tail_shading(
    aircraft: Aircraft, geometry: ModuleGeometry
) -> tuple[ShadedArea | None, str | None]:
    """Shading by the aircraft's tail, or why it is left out."""
    tail = getattr(aircraft.modules, "tail", None)
    if tail is None:
        return None, f"shading is not modelled: {aircraft.name} has no modules.tail"
    if any(surface.outline is None for surface in geometry.surfaces):
        return None, "shading is not modelled: a surface of modules.geometry has no outline"
    try:
        import_module("shapely")  # what the shading needs, and imports only when it is called
        from solar.shading import shaded_area
    except ImportError as error:
        return None, f"shading is not modelled: {error.name} is not installed"
    return lambda sun: np.asarray(shaded_area(geometry, tail, sun)), None


def _samples(
    log: FlightLog,
    aircraft: Aircraft,
    mission: Mission,
    geometry: ModuleGeometry | None,
    shade: ShadedArea | None,
) -> tuple[Samples, list[str]]:
    """Sunlit samples with all models on them, and where their temperatures are from."""
    sun = sun_position(log.time_s, log.latitude_deg, log.longitude_deg)
    index = np.flatnonzero(sun.elevation_rad > 0.0)
    if not len(index):
        highest = np.degrees(sun.elevation_rad.max())
        raise file_error(
            log.source,
            f"the sun never rises in this log (highest {highest:.1f} deg): there is no solar power "
            "to verify; are time_utc and longitude_deg right?",
        )
    ambient, source = _ambient_c(log, mission, index)
    module_c, module_source = _constant_module_c(log, mission, ambient)
    lit = _Lit(
        aircraft=aircraft,
        clearness=mission.clearness,
        day=day_of_year(log.time_s[index]),
        latitude_deg=log.latitude_deg[index],
        altitude_m=log.altitude_m[index],
        sun=sun.vector_ned[index],
        attitude=None
        if geometry is None or log.attitude is None
        else np.stack(log.attitude)[:, index],
        ambient_c=ambient,
        module_c=module_c,
    )
    modelled, detail = _modelled(lit, geometry, shade)
    bearing = np.zeros(len(index))
    if log.attitude is not None:
        bearing = np.degrees(sun.azimuth_rad[index] - log.attitude.yaw_rad[index]) % 360.0
    return (
        Samples(
            index=index,
            time_s=log.time_s[index],
            time_solar_h=sun.time_solar_h[index],
            solar_day=_solar_day(log, index, sun.time_solar_h[index]),
            run=_runs(index, log.segment()[index]),
            elevation_deg=np.degrees(sun.elevation_rad[index]),
            bearing_deg=bearing,
            measured_w=log.solar_power_w[index],
            modelled_w=modelled,
            detail=detail,
        ),
        [source, module_source],
    )


@dataclass(frozen=True)
class _Lit:
    """Sunlit samples as the models need them; ``attitude`` has the rows roll, pitch, yaw."""

    aircraft: Aircraft
    clearness: float
    day: FloatArray
    latitude_deg: FloatArray
    altitude_m: FloatArray
    sun: FloatArray
    attitude: FloatArray | None
    ambient_c: FloatArray
    module_c: float


def _ambient_c(log: FlightLog, mission: Mission, index: IntArray) -> tuple[FloatArray, str]:
    """Air temperature: of the log, else of the mission, else standard at the flown altitude."""
    given = mission.air.ambient_temperature_c
    if given is not None:
        other, name = np.full(len(index), given), f"{given:g} C of the mission"
    else:
        offset = mission.air.temperature_offset_k or 0.0
        flown = np.clip(log.altitude_m[index], MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
        other, name = standard_air(flown, offset).temperature_c, "standard air"
    if log.ambient_temperature_c is None:
        return other, f"ambient temperature: {name}"
    logged = log.ambient_temperature_c[index]
    missing = np.isnan(logged)
    rest = f", {name} in {missing.sum()} samples without" if missing.any() else ""
    return np.where(missing, other, logged), f"ambient temperature: logged{rest}"


def _constant_module_c(
    log: FlightLog, mission: Mission, ambient_c: FloatArray
) -> tuple[float, str]:
    """Constant module temperature of CDM, CAM and VM."""
    given = mission.air.module_temperature_c
    if given is not None:
        return given, f"constant module temperature: {given:g} C of the mission"
    mean = float(ambient_c.mean())
    return mean, f"constant module temperature: mean of the ambient one, {mean:.1f} C"


def _solar_day(log: FlightLog, index: IntArray, time_solar_h: FloatArray) -> IntArray:
    """Day by local solar time, days since 1970-01-01."""
    mean_h = log.time_s[index] / 3600.0 + log.longitude_deg[index] / 15.0
    # Mean and true solar time differ by a quarter of an hour at most, and so decide the day.
    return np.round((mean_h - time_solar_h) / 24.0).astype(int)


def _runs(index: IntArray, segment: IntArray) -> IntArray:
    """Number stretches of consecutive places within one segment."""
    breaks = (np.diff(index) > 1) | (np.diff(segment) > 0)
    return np.concatenate(([0], np.cumsum(breaks))).astype(int)


def _modelled(
    lit: _Lit, geometry: ModuleGeometry | None, shade: ShadedArea | None
) -> tuple[dict[ModelName, FloatArray], Detail | None]:
    """All models, chunk by chunk: a long log times its surfaces would fill the memory."""
    count = len(lit.day)
    chunks = [slice(i, i + _CHUNK) for i in range(0, count, _CHUNK)]
    horizontal = [_horizontal(lit, c) for c in chunks]
    models: dict[ModelName, FloatArray] = {
        "CDM": np.concatenate([h[0] for h in horizontal]),
        "CAM": np.concatenate([h[1] for h in horizontal]),
    }
    if geometry is None:
        return models, None
    parts = [_with_attitude(lit, c, geometry, shade) for c in chunks]
    columns = [
        None if column[0] is None else np.concatenate(column) for column in zip(*parts, strict=True)
    ]
    vm, fm, *rest = columns
    assert vm is not None
    assert fm is not None
    models |= {"VM": vm, "FM": fm}
    return models, Detail(*rest)  # type: ignore[arg-type]  # only the last two may be None


def _light(lit: _Lit, chunk: slice) -> Irradiance:
    clear = clear_sky(
        lit.day[chunk], lit.latitude_deg[chunk], -lit.sun[chunk, 2], lit.altitude_m[chunk]
    )
    return Irradiance(*(lit.clearness * part for part in clear))


def _horizontal(lit: _Lit, chunk: slice) -> tuple[FloatArray, FloatArray]:
    modules, cosine = lit.aircraft.modules, -lit.sun[chunk, 2]
    light = _light(lit, chunk)
    return (
        modules.area_m2 * conceptual_design_model(light, cosine, modules, lit.module_c),
        modules.area_m2 * conceptual_analysis_model(light, cosine, modules, lit.module_c),
    )


def _with_attitude(
    lit: _Lit, chunk: slice, geometry: ModuleGeometry, shade: ShadedArea | None
) -> tuple[FloatArray | None, ...]:
    """VM, FM and the fields of :class:`Detail`."""
    assert lit.attitude is not None  # so is the geometry
    modules, sun = lit.aircraft.modules, lit.sun[chunk]
    to_ned = direction_cosines(*lit.attitude[:, chunk])
    light = _light(lit, chunk)
    vm = modules.area_m2 * verification_model(light, sun, to_ned, geometry, modules, lit.module_c)
    full = full_model(
        light, sun, to_ned, geometry, modules, lit.ambient_c[chunk], shading=modules.shading
    )
    power = modules.area_m2 * full.specific_power_w_per_m2
    shares = geometry.area_shares
    shaded = lost = None
    if shade is not None:
        by_surface = shade(np.einsum("...ji,...j->...i", to_ned, sun))
        shaded = by_surface.sum(axis=-1)
        lost = power * _lost_share(full, light, by_surface, geometry, lit.aircraft)
    angles = np.degrees(np.arccos(np.clip(full.cos_aoi_by_surface, -1.0, 1.0)))
    return (
        vm,
        power,
        angles @ shares,
        full.irradiance_w_per_m2,
        full.module_efficiency,
        full.incidence_efficiency_by_surface @ shares,
        full.low_light_efficiency_by_surface @ shares,
        full.temperature_efficiency,
        full.mppt_efficiency,
        full.module_temperature_c,
        shaded,
        lost,
    )


def _lost_share(
    full: ModulePower,
    light: Irradiance,
    shaded_m2: FloatArray,
    geometry: ModuleGeometry,
    aircraft: Aircraft,
) -> FloatArray:
    """Share of the useful light that shadows take if they cost their area of direct light."""
    cell, shares = aircraft.modules, geometry.area_shares
    diffuse = light.dhi[:, np.newaxis]
    direct = full.irradiance_by_surface_w_per_m2 - diffuse
    useful = direct * full.incidence_efficiency_by_surface * cell.camber_efficiency
    total = (useful + diffuse * cell.diffuse_efficiency) @ shares
    covered = shaded_m2 / np.array([surface.area_m2 for surface in geometry.surfaces])
    return np.asarray((useful * covered) @ shares / np.maximum(total, 1e-12))


# ---- Errors


def moving_average(values: FloatArray, run: IntArray, semi_window: int) -> FloatArray:
    """Two-sided moving average over ``2 semi_window + 1`` samples that never leaves a run.

    Towards the ends of a run the window is cut, not mirrored.
    """
    place = np.arange(len(values))
    first = np.searchsorted(run, run, side="left")
    last = np.searchsorted(run, run, side="right")
    low = np.maximum(place - semi_window, first)
    high = np.minimum(place + semi_window + 1, last)
    total = np.concatenate(([0.0], np.cumsum(values)))
    return np.asarray((total[high] - total[low]) / (high - low))


def day_masks(samples: Samples) -> Iterator[tuple[str, BoolArray]]:
    """Dates of the log's days (UTC), and which samples are theirs."""
    days = np.floor(samples.time_s / SECONDS_PER_DAY).astype(int)
    for day in np.unique(days):
        yield _date(int(day)), days == day


def used_runs(samples: Samples, used: BoolArray) -> IntArray:
    """Runs of the samples that are used, numbered anew where others were left out."""
    return _runs(np.flatnonzero(used), samples.run[used])


def _in_window(samples: Samples, window: Window) -> BoolArray:
    hours = samples.time_solar_h
    inside = (hours >= window.start_h) & (hours <= window.end_h)
    if window.day is not None:
        inside &= samples.solar_day == window.day
    return np.asarray(inside, bool)


def _solar_span(samples: Samples) -> str:
    days = np.unique(samples.solar_day)
    spans = []
    for day in days:
        hours = samples.time_solar_h[samples.solar_day == day]
        spans.append(f"{_date(int(day))} {hours.min():.2f} to {hours.max():.2f} h")
    return ", ".join(spans)


def _sections(
    samples: Samples,
    excluded: BoolArray,
    semi_window: int,
    masks: Iterable[tuple[str, BoolArray]],
) -> tuple[Section, ...]:
    used = ~excluded
    run = used_runs(samples, used)
    measured = samples.measured_w[used]
    raw = {m: power[used] - measured for m, power in samples.modelled_w.items()}
    smooth = {m: moving_average(error, run, semi_window) for m, error in raw.items()}
    result = []
    for label, mask in masks:
        inside = mask[used]
        times = samples.time_s[mask]
        errors = {
            m: _model_errors(measured[inside], raw[m][inside], smooth[m][inside])
            for m in raw
            if inside.any()
        }
        result.append(
            Section(
                label=label,
                start_s=float(times[0]),
                end_s=float(times[-1]),
                samples=int(inside.sum()),
                excluded=int((mask & excluded).sum()),
                semi_window=semi_window,
                errors=errors,
            )
        )
    return tuple(result)


def _model_errors(measured: FloatArray, raw: FloatArray, smooth: FloatArray) -> ModelErrors:
    """Average of all samples, RMS and maximum of the filtered ones."""
    return ModelErrors(
        modelled_mean_w=float((measured + raw).mean()),
        measured_mean_w=float(measured.mean()),
        average_w=float(raw.mean()),
        rms_w=float(np.sqrt(np.mean(smooth**2))),
        maximum_w=float(np.abs(smooth).max()),
    )


# ---- Anomalies


@dataclass(frozen=True)
class _Scene:
    """Samples and the best model on them, levelled to the log's own good samples."""

    log: FlightLog
    samples: Samples
    reference_w: FloatArray
    rated_w: float
    step_s: float

    @classmethod
    def of(cls, log: FlightLog, samples: Samples, aircraft: Aircraft) -> _Scene:
        """Level the model: a constant bias of it is an error to report, not an anomaly."""
        modules = aircraft.modules
        model = samples.modelled_w.get("FM", samples.modelled_w["CAM"])
        rated = modules.full_load_w_per_m2 * modules.area_m2
        scene = cls(log, samples, model, rated, log.step_s)
        measured, smooth = scene.smooth(samples.measured_w, SMOOTH_S), scene.smooth(model, SMOOTH_S)
        bright = smooth >= BRIGHT * rated
        level = 1.0
        if bright.any():
            # The upper quartile, since limited power lowers up to three quarters of the samples.
            level = float(np.clip(np.quantile(measured[bright] / smooth[bright], 0.75), 0.7, 1.3))
        return cls(log, samples, level * model, rated, log.step_s)

    def smooth(self, values: FloatArray, seconds: float) -> FloatArray:
        """Moving average over so many seconds to either side."""
        return moving_average(values, self.samples.run, round(seconds / self.step_s))

    def logged(self, values: FloatArray | None) -> FloatArray | None:
        """Values of the log at the sunlit samples."""
        return None if values is None else values[self.samples.index]

    def lost_wh(self, mask: NDArray[Any]) -> float:
        """Energy between the model and the measurement in some samples [Wh]."""
        missing = (self.reference_w - self.samples.measured_w)[mask]
        return float(missing.sum() * self.step_s / 3600.0)

    def severity_of_loss(self, lost_wh: float) -> Severity:
        """By the share of the energy of the whole log."""
        whole_wh = float(self.reference_w.sum()) * self.step_s / 3600.0
        return _severity(lost_wh / max(whole_wh, 1e-9), 0.01)


def _severity(share: float, minor: float, factor: float = 5.0) -> Severity:
    if share < minor:
        return "minor"
    return "moderate" if share < factor * minor else "major"


class _Period(NamedTuple):
    """Samples from the first to the last of a cluster, the latter included."""

    first: int
    last: int

    def slice(self) -> slice:
        return slice(self.first, self.last + 1)


def _clusters(flagged: BoolArray, time_s: FloatArray, merge_s: float) -> list[_Period]:
    """Join flagged samples that are less than some seconds apart."""
    places = np.flatnonzero(flagged)
    if not len(places):
        return []
    cuts = np.flatnonzero(np.diff(time_s[places]) > merge_s)
    firsts = places[np.concatenate(([0], cuts + 1))]
    lasts = places[np.concatenate((cuts, [len(places) - 1]))]
    return [_Period(int(a), int(b)) for a, b in zip(firsts, lasts, strict=True)]


def _battery_full(scene: _Scene) -> tuple[list[Anomaly], BoolArray]:
    """Periods in which power is limited because the battery is nearly full."""
    ratio, bright = _power_ratio(scene)
    charge = scene.logged(scene.log.state_of_charge)
    sure = charge is not None and scene.samples.detail is not None
    flagged = bright & (ratio < (LIMITED if sure else LIMITED_UNSURE))
    if charge is not None:
        # NaN compares false: samples without a charge are judged by neither rule.
        flagged &= charge >= NEAR_FULL
    found, limited = [], np.zeros(len(ratio), bool)
    for period in _clusters(flagged, scene.samples.time_s, _MERGE_S):
        if flagged[period.slice()].sum() * scene.step_s < LIMITED_LEAST_S:
            continue
        reason = _why_limited(scene, period, charge, ratio)
        if reason is None:
            continue
        whole = _widened(scene, period, ratio)
        limited[whole.slice()] = True
        found.append(_limitation(scene, whole, ratio, reason))
    return found, limited


def _power_ratio(scene: _Scene) -> tuple[FloatArray, BoolArray]:
    """Measured over modelled power around each sample, and where there is enough to judge it.

    Samples at low light are left out: there the trackers may fail, which is another finding, and
    a limit never acts on little power.
    """
    detail = scene.samples.detail
    counts = np.ones(len(scene.reference_w))
    if detail is not None:
        counts = (detail.irradiance_w_per_m2 >= LOW_LIGHT_W_PER_M2).astype(float)
    share = np.maximum(scene.smooth(counts, SMOOTH_S), 1e-9)
    measured = scene.smooth(counts * scene.samples.measured_w, SMOOTH_S) / share
    modelled = scene.smooth(counts * scene.reference_w, SMOOTH_S) / share
    judged = (share >= LEAST_JUDGED) & (modelled >= BRIGHT * scene.rated_w)
    return np.where(judged, measured / np.maximum(modelled, 1e-9), 1.0), judged


def _why_limited(
    scene: _Scene, period: _Period, charge: FloatArray | None, ratio: FloatArray
) -> str | None:
    """Evidence that the battery is behind the missing power, none if there is none."""
    if charge is not None:
        mean = float(np.nanmean(charge[period.slice()]))
        return f"state of charge {mean:.0%} on average"
    load = scene.logged(scene.log.load_w)
    if load is not None:
        apart = np.abs(scene.samples.measured_w - load)[period.slice()]
        known = apart[np.isfinite(apart)]
        if len(known) and np.median(known) < LOAD_MATCH * scene.rated_w:
            return "power follows the load (no state of charge logged)"
    time_s = scene.samples.time_s
    before = slice(int(np.searchsorted(time_s, time_s[period.first] - 300.0)), period.first)
    if np.any(ratio[before] >= LIMITED):
        return "sudden drop at high light (no state of charge logged, so clouds are not ruled out)"
    return None


def _widened(scene: _Scene, period: _Period, ratio: FloatArray) -> _Period:
    """Extend a period to where the power is whole again, plus what the smoothing hides."""
    time_s = scene.samples.time_s
    whole = ratio >= UNLIMITED
    before = np.flatnonzero(whole[: period.first])
    after = np.flatnonzero(whole[period.last :])
    start = time_s[before[-1]] if len(before) else time_s[0]
    end = time_s[period.last + after[0]] if len(after) else time_s[-1]
    start = max(start, time_s[period.first] - 300.0) - SMOOTH_S
    end = min(end, time_s[period.last] + 300.0) + SMOOTH_S
    return _Period(
        int(np.searchsorted(time_s, start)), int(np.searchsorted(time_s, end, side="right")) - 1
    )


def _limitation(scene: _Scene, period: _Period, ratio: FloatArray, reason: str) -> Anomaly:
    inside = period.slice()
    lost = scene.lost_wh(_mask(len(ratio), period))
    lowest = float(ratio[inside].min())
    return _anomaly(
        scene,
        "battery_full",
        period,
        scene.severity_of_loss(lost),
        f"power down to {lowest:.0%} of the model while {BRIGHT:.0%} of rated power or more is "
        f"there; {reason}; not counted in the errors",
        (inside.stop - inside.start) * scene.step_s,
        lost,
    )


def _mask(count: int, period: _Period) -> BoolArray:
    mask = np.zeros(count, bool)
    mask[period.slice()] = True
    return mask


def _anomaly(
    scene: _Scene,
    kind: Kind,
    period: _Period,
    severity: Severity,
    evidence: str,
    affected_s: float,
    lost_wh: float,
) -> Anomaly:
    time_s = scene.samples.time_s
    start, end = float(time_s[period.first]), float(time_s[period.last])
    return Anomaly(kind, start, end, severity, evidence, affected_s, lost_wh)


def _other_anomalies(scene: _Scene, limited: BoolArray) -> list[Anomaly]:
    """All but limited charging; those that compare with the Full Model need it."""
    found = _missing(scene)
    if scene.samples.detail is None:
        return found
    tracking, dark = _not_tracking(scene, limited)
    return [*found, *tracking, *_shading(scene, limited), *_side_bias(scene, limited | dark)]


def _noise_w(scene: _Scene) -> float:
    """Scatter of the error from sample to sample, robust against everything slower [W]."""
    error = scene.samples.measured_w - scene.reference_w
    steps = np.diff(error)[np.diff(scene.samples.run) == 0]
    if not len(steps):
        return 0.0
    return float(1.4826 * np.median(np.abs(steps - np.median(steps))) / np.sqrt(2.0))


def _not_tracking(scene: _Scene, limited: BoolArray) -> tuple[list[Anomaly], BoolArray]:
    """Periods in which trackers lose the maximum power point at low light."""
    detail = scene.samples.detail
    assert detail is not None  # the caller checked
    low = (detail.irradiance_w_per_m2 < LOW_LIGHT_W_PER_M2) & ~limited
    low &= scene.reference_w >= LOW_LIGHT_DEFICIT_RATED * scene.rated_w
    if detail.shaded_m2 is not None:
        low &= detail.shaded_m2 <= 0.0
    modelled = scene.smooth(scene.reference_w, _NEAR_S)
    deficit = modelled - scene.smooth(scene.samples.measured_w, _NEAR_S)
    averaged = 2 * round(_NEAR_S / scene.step_s) + 1
    noise = LOW_LIGHT_SIGMAS * _noise_w(scene) / np.sqrt(averaged)
    least = max(LOW_LIGHT_DEFICIT_RATED * scene.rated_w, noise)
    flagged = low & (deficit > np.maximum(LOW_LIGHT_DEFICIT * modelled, least))
    odd_voltage = _odd_voltage(scene)
    found, lost = [], np.zeros(len(low), bool)
    for period in _clusters(flagged, scene.samples.time_s, _MERGE_S):
        anomaly = _tracking_anomaly(scene, period, flagged, low, odd_voltage)
        if anomaly is not None:
            found.append(anomaly)
            lost |= flagged & _mask(len(low), period)
    return found, lost


def _tracking_anomaly(
    scene: _Scene,
    period: _Period,
    flagged: BoolArray,
    low: BoolArray,
    odd_voltage: BoolArray | None,
) -> Anomaly | None:
    inside = _mask(len(flagged), period)
    bad = flagged & inside
    affected = float(bad.sum() * scene.step_s)
    if affected < LOW_LIGHT_LEAST_S or bad.sum() < LOW_LIGHT_SHARE * (low & inside).sum():
        return None
    voltage = "no tracker voltage logged"
    if odd_voltage is not None:
        share = float(odd_voltage[bad].mean())
        if share < VOLTAGE_SHARE:
            return None
        voltage = f"tracker voltage off or unsteady in {share:.0%} of them"
    missing = 1.0 - float(scene.samples.measured_w[bad].sum() / scene.reference_w[bad].sum())
    lost = scene.lost_wh(bad)
    return _anomaly(
        scene,
        "mppt_not_tracking",
        period,
        scene.severity_of_loss(lost),
        f"{missing:.0%} of the modelled power missing in {affected:.0f} s below "
        f"{LOW_LIGHT_W_PER_M2:g} W/m2 on the modules; {voltage}",
        affected,
        lost,
    )


def _odd_voltage(scene: _Scene) -> BoolArray | None:
    """Samples whose tracker voltage is away from its median at good light, or unsteady."""
    volts = scene.logged(scene.log.mppt_voltage_v)
    if volts is None:
        return None
    good = np.isfinite(volts) & (scene.reference_w >= BRIGHT * scene.rated_w)
    if good.sum() < 10:
        good = np.isfinite(volts)
    median = float(np.median(volts[good]))
    spread = 1.4826 * float(np.median(np.abs(volts[good] - median)))
    allowed = max(5.0 * spread, VOLTAGE_OFF * median)
    filled = np.where(np.isfinite(volts), volts, median)
    mean = scene.smooth(filled, _NEAR_S)
    variance = scene.smooth((filled - median) ** 2, _NEAR_S) - (mean - median) ** 2
    unsteady = np.sqrt(np.maximum(variance, 0.0)) > allowed
    return np.asarray((np.abs(filled - median) > allowed) | unsteady, bool)


def _shading(scene: _Scene, limited: BoolArray) -> list[Anomaly]:
    """Dips of the power that coincide with the modelled shadow of the tail."""
    detail = scene.samples.detail
    assert detail is not None  # the caller checked
    if detail.shaded_m2 is None or detail.shading_loss_w is None:
        return []
    # Shadows too small to cost what would be told apart from noise are left out.
    least = 0.5 * SHADING_LOSS_RATED * scene.rated_w
    shaded = (detail.shading_loss_w > least) & ~limited
    clear = (detail.shaded_m2 <= 0.0) & ~limited
    deficit = scene.reference_w - scene.samples.measured_w
    found = []
    for period in _clusters(shaded, scene.samples.time_s, _MERGE_S):
        dips = _dips(scene, period, shaded, clear, deficit)
        bad = shaded & _mask(len(shaded), period)
        if (anomaly := _shading_anomaly(scene, period, dips, bad)) is not None:
            found.append(anomaly)
    return found


def _dips(
    scene: _Scene, period: _Period, shaded: BoolArray, clear: BoolArray, deficit: FloatArray
) -> FloatArray:
    """Deficit of each passage of the shadow above that right before and after it [W]."""
    time_s, inside = scene.samples.time_s, np.flatnonzero(shaded[period.slice()]) + period.first
    passages = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1)
    dips = []
    for passage in passages:
        low = int(np.searchsorted(time_s, time_s[passage[0]] - 3 * _NEAR_S))
        high = int(np.searchsorted(time_s, time_s[passage[-1]] + 3 * _NEAR_S, side="right"))
        beside = clear[low:high]
        if beside.any():
            dips.append(deficit[passage].mean() - deficit[low:high][beside].mean())
    return np.array(dips)


def _shading_anomaly(
    scene: _Scene, period: _Period, dips: FloatArray, bad: BoolArray
) -> Anomaly | None:
    detail = scene.samples.detail
    assert detail is not None
    assert detail.shading_loss_w is not None
    assert detail.shaded_m2 is not None
    if len(dips) < 3:
        return None
    mean = float(dips.mean())
    error = float(dips.std(ddof=1)) / np.sqrt(len(dips))
    modelled = float(scene.reference_w[bad].mean())
    expected = float(detail.shading_loss_w[bad].mean())
    least = max(
        SHADING_LOSS * modelled,
        SHADING_LOSS_RATED * scene.rated_w,
        SHADING_OF_EXPECTED * expected,
        SHADING_T * error,
    )
    if mean < least:
        return None
    affected = float(bad.sum() * scene.step_s)
    lost = mean * affected / 3600.0
    return _anomaly(
        scene,
        "shading",
        period,
        scene.severity_of_loss(lost),
        f"power drops by {mean:.1f} W ({mean / modelled:.0%}) in {len(dips)} passages of the "
        f"tail's shadow, of up to {detail.shaded_m2[bad].max():.3f} m2; in proportion to the area "
        f"it would be {expected:.1f} W",
        affected,
        lost,
    )


def _side_bias(scene: _Scene, left_out: BoolArray) -> list[Anomaly]:
    """Sides of the nose on which the sun makes the error differ from that on the others."""
    samples = scene.samples
    low, high = SIDE_ELEVATIONS_DEG
    good = ~left_out & (samples.elevation_deg > low) & (samples.elevation_deg < high)
    good &= scene.reference_w >= 0.1 * scene.rated_w
    if samples.detail is not None and samples.detail.shaded_m2 is not None:
        good &= samples.detail.shaded_m2 <= 0.0
    if not good.any():
        return []
    side = (np.floor((samples.bearing_deg + 45.0) / 90.0).astype(int) % 4)[good]
    block = np.floor(samples.time_s[good] / SIDE_BLOCK_S).astype(int)
    _, block = np.unique(block, return_inverse=True)
    cell = 4 * block + side
    size = 4 * (int(block.max()) + 1)
    error = np.bincount(cell, (scene.reference_w - samples.measured_w)[good], minlength=size)
    power = np.bincount(cell, samples.measured_w[good], minlength=size)
    counts = np.bincount(cell, minlength=size)
    enough = (counts >= 10) & (power > 0.0)
    relative = np.where(enough, error / np.where(enough, power, 1.0), np.nan).reshape(-1, 4)
    places = np.flatnonzero(good)
    period = _Period(int(places[0]), int(places[-1]))
    found = []
    for number, name in enumerate(_SIDES):
        bad = np.zeros(len(good), bool)
        bad[places[side == number]] = True
        difference = _against_others(relative, number)
        if (anomaly := _side_anomaly(scene, period, name, difference, bad)) is not None:
            found.append(anomaly)
    return found


def _against_others(relative: FloatArray, number: int) -> FloatArray:
    """Error on one side less the median of the other sides, for blocks that have three others."""
    whole = relative[~np.isnan(relative).any(axis=1)]
    others = np.delete(whole, number, axis=1)
    # The median: a fault on one side must not show as an opposite one on the others.
    return np.asarray(whole[:, number] - np.median(others, axis=1))


def _side_anomaly(
    scene: _Scene, period: _Period, name: str, difference: FloatArray, bad: BoolArray
) -> Anomaly | None:
    if len(difference) < 3:
        return None
    mean = float(difference.mean())
    error = float(difference.std(ddof=1)) / np.sqrt(len(difference))
    same_sign = float(np.mean(np.sign(difference) == np.sign(mean)))
    if abs(mean) < max(SIDE_BIAS, SIDE_T * error) or same_sign < SIDE_SAME_SIGN:
        return None
    where = {"front": "ahead", "right": "on the right", "rear": "behind", "left": "on the left"}
    word = "over" if mean > 0.0 else "under"
    return _anomaly(
        scene,
        "side_bias",
        period,
        _severity(abs(mean), SIDE_BIAS, 3.0),
        f"with the sun {where[name]} the model {word}estimates by {abs(mean):.1%} more than with "
        f"the sun elsewhere, alike in {same_sign:.0%} of {len(difference)} blocks of "
        f"{SIDE_BLOCK_S / 60:g} min",
        float(bad.sum() * scene.step_s),
        max(scene.lost_wh(bad), 0.0),
    )


def _missing(scene: _Scene) -> list[Anomaly]:
    """Stretches without samples while the sun is up; those close together are one finding."""
    lit = [(gap, sunlit) for gap in scene.log.gaps if (sunlit := _sunlit_s(scene.log, gap)) > 0.0]
    groups: list[list[tuple[Gap, float]]] = []
    for gap, sunlit in lit:
        if groups and gap.start_s - groups[-1][-1][0].end_s <= _MERGE_S:
            groups[-1].append((gap, sunlit))
        else:
            groups.append([(gap, sunlit)])
    known_s = len(scene.samples.time_s) * scene.step_s
    return [_missing_anomaly(group, known_s) for group in groups]


def _missing_anomaly(group: Sequence[tuple[Gap, float]], known_s: float) -> Anomaly:
    total = sum(sunlit for _, sunlit in group)
    count = "1 gap" if len(group) == 1 else f"{len(group)} gaps"
    return Anomaly(
        "missing_data",
        group[0][0].start_s,
        group[-1][0].end_s,
        _severity(total / (known_s + total), 0.01),
        f"{count}, {total:.0f} s without samples while the sun is up",
        total,
        0.0,
    )


def _sunlit_s(log: FlightLog, gap: Gap) -> float:
    """Part of a gap with the sun above the horizon, seen from where it begins [s]."""
    at = int(np.searchsorted(log.time_s, gap.start_s))
    steps = np.linspace(gap.start_s, gap.end_s, 201)
    sun = sun_position(steps, log.latitude_deg[at], log.longitude_deg[at])
    return float(np.mean(sun.elevation_rad > 0.0) * gap.duration_s)


# ---- Results as data


def _date(day: int) -> str:
    return (datetime.date(1970, 1, 1) + datetime.timedelta(days=day)).isoformat()


def utc_label(time_s: float) -> str:
    """Universal time as ISO 8601, to the second."""
    instant = datetime.datetime.fromtimestamp(round(time_s), datetime.UTC)
    return instant.strftime("%Y-%m-%dT%H:%M:%SZ")


def to_json(result: Verification) -> dict[str, Any]:
    """Everything but the samples, JSON-ready."""
    log, samples = result.log, result.samples
    return {
        "aircraft": result.aircraft,
        "mission": result.mission,
        "log": {
            "source": log.source,
            "start": utc_label(float(log.time_s[0])),
            "end": utc_label(float(log.time_s[-1])),
            "samples": len(log),
            "sunlit_samples": len(samples.time_s),
            "rows_read": log.rows_read,
            "rows_dropped": log.rows_dropped,
            "step_s": log.step_s,
            "gaps": [{"start": utc_label(g.start_s), "end": utc_label(g.end_s)} for g in log.gaps],
        },
        "models": list(samples.modelled_w),
        "excluded_samples": int(result.excluded.sum()),
        "windows": [_section_record(section) for section in result.windows],
        "days": [_section_record(section) for section in result.days],
        "anomalies": [
            {
                "kind": a.kind,
                "start": utc_label(a.start_s),
                "end": utc_label(a.end_s),
                "severity": a.severity,
                "affected_s": a.affected_s,
                "lost_wh": a.lost_wh,
                "evidence": a.evidence,
            }
            for a in result.anomalies
        ],
        "notes": list(result.notes),
    }


def _section_record(section: Section) -> dict[str, Any]:
    some = next(iter(section.errors.values()), None)
    return {
        "label": section.label,
        "start": utc_label(section.start_s),
        "end": utc_label(section.end_s),
        "samples": section.samples,
        "excluded_samples": section.excluded,
        "filter_semi_window": section.semi_window,
        "measured_mean_w": None if some is None else some.measured_mean_w,
        "models": {m: _errors_record(e) for m, e in section.errors.items()},
    }


def _errors_record(errors: ModelErrors) -> dict[str, float | None]:
    return {
        "modelled_mean_w": errors.modelled_mean_w,
        "average_error_w": errors.average_w,
        "average_error_relative": errors.relative(errors.average_w),
        "rms_error_w": errors.rms_w,
        "rms_error_relative": errors.relative(errors.rms_w),
        "maximum_error_w": errors.maximum_w,
        "maximum_error_relative": errors.relative(errors.maximum_w),
    }


def samples_csv(result: Verification) -> str:
    """Samples with models and errors as CSV text.

    Written by hand: a data frame takes several times as long for the quarter of a million rows of a
    long flight.
    """
    names, formats, columns = zip(*_csv_columns(result), strict=True)
    row = ",".join(formats)
    lines = [row % values for values in zip(*(c.tolist() for c in columns), strict=True)]
    return "\n".join([",".join(names), *lines]) + "\n"


def _csv_columns(result: Verification) -> Iterator[tuple[str, str, NDArray[Any]]]:
    samples, log = result.samples, result.log
    yield "time_utc_s", "%.3f", samples.time_s
    yield "time_solar_h", "%.5f", samples.time_solar_h
    yield "sun_elevation_deg", "%.3f", samples.elevation_deg
    if log.attitude is not None:
        yield "sun_bearing_deg", "%.2f", samples.bearing_deg
    yield "solar_power_w", "%.3f", samples.measured_w
    for model, power in samples.modelled_w.items():
        yield f"{model.lower()}_w", "%.3f", power
    for model, power in samples.modelled_w.items():
        yield f"{model.lower()}_error_w", "%.3f", power - samples.measured_w
    if (detail := samples.detail) is not None:
        yield "angle_of_incidence_deg", "%.2f", detail.incidence_deg
        yield "irradiance_w_per_m2", "%.2f", detail.irradiance_w_per_m2
        yield "module_efficiency", "%.4f", detail.module_efficiency
        yield "mppt_efficiency", "%.4f", detail.mppt_efficiency
        yield "module_temperature_c", "%.2f", detail.module_temperature_c
        if detail.shaded_m2 is not None:
            yield "shaded_area_m2", "%.4f", detail.shaded_m2
    if log.mppt_voltage_v is not None:
        yield "mppt_voltage_v", "%.3f", log.mppt_voltage_v[samples.index]
    yield "excluded", "%d", result.excluded.astype(int)
