"""Records of a verification: JSON, and the samples as CSV."""

from __future__ import annotations

import datetime
from collections.abc import Iterator
from typing import Any

from numpy.typing import NDArray

from studies.flight_logs.errors import ModelErrors, Section
from studies.flight_logs.verification import Verification


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
