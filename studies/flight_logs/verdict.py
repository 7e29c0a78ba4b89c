"""One sentence for each model, and one for each thing that may be wrong with log and modules."""

from __future__ import annotations

import datetime
from collections.abc import Iterator

import numpy as np

from sizing.aircraft import Aircraft
from solar.names import ModelName
from studies.flight_logs.causes.diagnosis import Diagnosis, snapped
from studies.flight_logs.causes.fit import Loss
from studies.flight_logs.causes.hypotheses import Candidate, Family
from studies.flight_logs.errors import ModelErrors
from studies.flight_logs.log_view import LOW_LIGHT_W_PER_M2

# The Full Model was within 2 % on average in the report, and a clear day is known to a few per
# cent: what is within this is as good as the models are.
AGREES_PERCENT, SCATTER_PERCENT = 3.0, 6.0
# What is no number: standard deviations above these [s, rad].
UNKNOWN_TIME_S, UNKNOWN_HEADING = 1800.0, float(np.radians(10.0))
_AIR_MASS = 1.5  # of the reference spectrum AM1.5


def model_sentence(model: ModelName, errors: ModelErrors | None, filter_s: float) -> str:
    """What a model is worth on this flight; without errors no sample counts."""
    if errors is None:
        return f"{model}: nothing to compare, no sample counts"
    relative, scatter = errors.relative(errors.average_w), errors.relative(errors.rms_w)
    if relative is None or scatter is None:
        return (
            f"{model}: {errors.measured_mean_w:.4g} W are measured on average: no power of "
            "modules; is it the right column, with the right sign?"
        )
    mean, rms = 100.0 * relative, 100.0 * scatter
    numbers = f"{mean:+.1f} % on average, RMS {rms:.1f} %"
    if abs(mean) <= AGREES_PERCENT and rms <= SCATTER_PERCENT:
        return f"{model} agrees with the flight ({numbers})"
    word = "above" if mean > 0.0 else "below"
    if abs(mean) <= AGREES_PERCENT:
        return f"{model} is right on average but not at every hour ({numbers})"
    if rms <= 1.25 * abs(mean) + 1.0:
        return f"{model} is {abs(mean):.1f} % {word} the flight at all hours ({numbers})"
    return f"{model} is {abs(mean):.1f} % {word} the flight, and not alike at all hours ({numbers})"


def words_of(candidate: Candidate, aircraft: Aircraft) -> str:
    """What a cause says, with its size."""
    size, sigma, row, name = candidate.size, candidate.sigma, candidate.row, candidate.name
    share = f"{100.0 * abs(size):.0f} ± {100.0 * sigma:.0f} %"
    if row.signs:
        return f"{name} wrong"
    if row.form == "modules":
        return _modules_words(candidate, aircraft)
    if row.form == "cap":
        return f"power sensor saturated at {candidate.fit.hypothesis.cap_w:.0f} W"
    when = _period(candidate.fit.hypothesis.losses[-1]) if row.form else ""
    part = _partly(candidate, aircraft) if row.form else ""
    of = f" of{part}" if part else ""
    words = {
        "power loss": f"no power at all{of} {when}",
        "mppt": f"MPPT{of} held below its point: {share} of the power missing {when}",
        "cloud": f"cloud: {share} of the direct light missing {when}",
        "mppt at low light": f"MPPT not tracking below {LOW_LIGHT_W_PER_M2:g} W/m²: {share} of the "
        f"power missing {when}",
        "shading": f"shadow of the tail: costs {share} of what it would in proportion to its area",
        "gain": f"power {100.0 * (1.0 + size):.0f} ± {100.0 * sigma:.0f} % of what the modules "
        "should give: gain of the sensor, or efficiency of the modules",
        "sky": _sky_words(size),
    }
    if name in words:
        return words[name]
    clock = f"clock {_clock_words(size, sigma)}"
    if name == "clock":
        return clock
    if name == "clock and heading":
        turned = candidate.of_each()[1]
        heading = f"{_degrees(turned.size):+.1f} ± {np.degrees(turned.sigma):.1f} deg"
        return f"{clock}, and heading off by {heading}"
    way = {"heading": "clockwise", "roll": "right wing down", "pitch": "nose up"}[name]
    return f"{name} off by {_degrees(size):+.1f} ± {np.degrees(sigma):.1f} deg ({way} is positive)"


def _sky_words(haze: float) -> str:
    light = 100.0 * abs(1.0 - float(np.exp(-_AIR_MASS * haze)))
    word, less = ("hazier", "less") if haze > 0.0 else ("clearer", "more")
    return f"sky {word} than the model's: {light:.0f} % {less} direct light at an air mass of 1.5"


def _degrees(angle: float) -> float:
    return float((np.degrees(angle) + 180.0) % 360.0 - 180.0)


def _partly(candidate: Candidate, aircraft: Aircraft) -> str:
    """Names of the modules that a loss acts on, if not on all."""
    on, geometry = candidate.fit.hypothesis.losses[-1].surfaces, aircraft.modules.geometry
    if all(on) or geometry is None:
        return ""
    return " " + ", ".join(s.name for s, lost in zip(geometry.surfaces, on, strict=True) if lost)


def _modules_words(candidate: Candidate, aircraft: Aircraft) -> str:
    loss = candidate.fit.hypothesis.losses[-1]
    gone = abs(1.0 - candidate.size) < max(3.0 * candidate.sigma, 0.05)
    share = f"{100.0 * candidate.size:.0f} ± {100.0 * candidate.sigma:.0f} %"
    lost = "give nothing" if gone else f"give {share} less than they should"
    when = _period(loss) if candidate.jumps else "all the time"
    return f"modules{_partly(candidate, aircraft)} {lost} {when}"


def _period(loss: Loss) -> str:
    start, end = (
        datetime.datetime.fromtimestamp(t, datetime.UTC).strftime("%H:%M")
        for t in (loss.start_s, loss.end_s)
    )
    return f"from {start} to {end} UTC"


def _clock_words(ahead_s: float, sigma_s: float) -> str:
    word = "ahead of" if ahead_s > 0.0 else "behind"
    zone = snapped(ahead_s, sigma_s)
    hours, minutes = divmod(round(abs(zone) / 60.0), 60)
    sign = "+" if zone > 0.0 else "-"
    known = (
        ""
        if zone == ahead_s or not zone
        else (f", as a clock of UTC{sign}{hours:02d}:{minutes:02d} is")
    )
    return f"{abs(ahead_s) / 60.0:.1f} ± {sigma_s / 60.0:.1f} min {word} universal time{known}"


# What flight would tell causes of two families apart.
_TO_TELL: dict[frozenset[Family], str] = {
    frozenset({"attitude"}): "circles in both directions at 15 deg of bank or more",
    frozenset({"time", "attitude"}): "circles in both directions, in the morning and the afternoon",
    frozenset(
        {"attitude", "modules"}
    ): "circles in both directions: an error of the attitude turns "
    "with them, missing modules do not",
    frozenset({"time"}): "a log at another longitude, or a look at the clock and the receiver",
    frozenset({"level"}): "the same circles at high and at low sun",
    frozenset({"level", "modules"}): "circles at 15 deg of bank or more with the sun below 40 deg",
    frozenset({"modules", "period"}): "circles at 15 deg of bank or more with the sun below 40 deg",
    frozenset({"period"}): "circles at 15 deg of bank or more, and a logged irradiance",
}
_OTHERWISE = "a whole day of circles in both directions"


def log_sentences(
    diagnosis: Diagnosis, aircraft: Aircraft, *, corrected: bool
) -> Iterator[tuple[str, bool]]:
    """What the power says of log, modules and sky, and whether that is an error."""
    how = "compared as corrected" if corrected else "compared as logged"
    if diagnosis.unit != "W":
        yield f"unit of the log: the power is in {diagnosis.unit}, not W; {how}", True
    if diagnosis.factor < 0.0:
        yield f"sign of the log: the power is negative; {how}", True
    for finding in diagnosis.findings:
        text = words_of(finding.best, aircraft)
        others = [words_of(one, aircraft) for one in finding.others]
        battery = f"battery nearly full ({finding.battery})"
        if finding.normal:
            text, others = battery, [text, *others]
        elif finding.battery:
            others.append(battery)
        if others:
            text += f"; fits about as well: {'; or '.join(others)}"
        if finding.others and not finding.alike:
            families = frozenset({finding.best.row.family, finding.others[0].row.family})
            text += f"; to tell them apart: {_TO_TELL.get(families, _OTHERWISE)}"
        if finding.best.row.family in ("time", "attitude"):
            text += f"; {how if diagnosis.certain else 'not corrected, since it is not certain'}"
        yield text, finding.best.row.name != "sky" and not finding.normal
    for name, offset, scale, unit, unknown in (
        ("clock", diagnosis.clock, 60.0, "min", UNKNOWN_TIME_S),
        ("heading", diagnosis.heading, float(np.radians(1.0)), "deg", UNKNOWN_HEADING),
    ):
        key = {"clock": "clock_s"}.get(name, name)
        if offset is not None and not diagnosis.named(key):
            yield _offset_sentence(name, offset, scale, unit, unknown), False
    if diagnosis.sky is not None:
        yield _sky_words(diagnosis.sky[0]), False
    for note in diagnosis.notes:
        yield note, False


def _offset_sentence(
    name: str, offset: tuple[float, float], scale: float, unit: str, unknown: float
) -> str:
    """Whether an offset that is no finding is right."""
    value, sigma = offset
    if not sigma < unknown:
        return f"{name} not checked: the power does not tell it on this flight"
    size = f"{value / scale:+.1f} ± {sigma / scale:.1f} {unit}"
    if abs(value) < 3.0 * sigma:
        return f"{name} of the log: right within its uncertainty ({size})"
    return f"{name} of the log: {size}, which errors of model and sky explain about as well"
