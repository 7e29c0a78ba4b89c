"""One sentence for each model, and one for each thing that the log itself may have wrong."""

from __future__ import annotations

from collections.abc import Iterator

from solar.names import ModelName
from studies.flight_logs.alignment.offsets import HALF_HOUR_S, Alignment
from studies.flight_logs.errors import ModelErrors

# The Full Model was within 2 % on average in the report, and a clear day is known to a few per
# cent: what is within this is as good as the models are.
AGREES_PERCENT, SCATTER_PERCENT = 3.0, 6.0


def model_sentence(model: ModelName, errors: ModelErrors | None, filter_s: float) -> str:
    """What a model is worth on this flight.

    ``errors``: errors over the whole log; None if no sample counts. ``filter_s``: time to either
    side in the average before the RMS [s].
    """
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


def log_sentences(alignment: Alignment, *, corrected: bool) -> Iterator[tuple[str, bool]]:
    """What the power says of the log itself, and whether it is an error.

    ``corrected``: whether the models are compared with the corrected log.
    """
    how = "compared as corrected" if corrected else "compared as logged"
    if alignment.power_unit != "W":
        yield f"unit of the log: the power is in {alignment.power_unit}, not W; {how}", True
    if (clock := alignment.clock_ahead_s) is not None:
        # Beyond two minutes a word says which way.
        size_s = clock.value if not abs(clock.value) > 120.0 else abs(clock.value)
        minutes = f"{size_s / 60.0:.1f} +- {clock.sigma / 60.0:.1f} min"
        if alignment.clock_wrong:
            word = "ahead of" if clock.value > 0.0 else "behind"
            zone = _zone(alignment)
            yield f"clock of the log: {minutes} {word} universal time{zone}; {how}", True
        else:
            yield f"clock of the log: right within its uncertainty ({minutes})", False
    if (heading := alignment.heading_ahead_deg) is not None:
        size = f"{heading.value:+.1f} +- {heading.sigma:.1f} deg"
        if alignment.heading_wrong:
            yield f"heading of the log: off by {size} (clockwise is positive); {how}", True
        else:
            yield f"heading of the log: right within its uncertainty ({size})", False
    for note in alignment.notes:
        yield note, False


def _zone(alignment: Alignment) -> str:
    """Time zone that would explain an error of the clock."""
    half_hours, rest = divmod(alignment.clock_correction_s, HALF_HOUR_S)
    if rest:
        return ""
    hours, half = divmod(int(abs(half_hours)), 2)
    return f", as a clock of UTC{'+' if half_hours > 0 else '-'}{hours:02d}:{30 * half:02d} is"
