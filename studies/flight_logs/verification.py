"""Solar power models against a flight log: errors, and what looks wrong in the flight.

The errors are those of :mod:`studies.flight_logs.errors`; what is wrong is decided by the causes of
:mod:`studies.flight_logs.causes`, which compete.
"""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missions.files.errors import InputError, file_error
from missions.library import load_mission
from missions.logs.csv import read_flight_log
from missions.logs.plausible import LeftOut, utc_text
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.results.tables import Column, Line, Result, Summary, Table
from solar.types import BoolArray
from studies.flight_logs.anomalies import Anomalies
from studies.flight_logs.causes.diagnosis import Diagnosis, diagnose
from studies.flight_logs.causes.forward import Forward, LogError, ShadedArea
from studies.flight_logs.errors import (
    ModelErrors,
    Section,
    Window,
    day_masks,
    in_window,
    parse_window,
    sections,
    solar_span,
)
from studies.flight_logs.log_view import Anomaly
from studies.flight_logs.samples import Samples, lit_samples, module_geometry, tail_shading
from studies.flight_logs.trackers import TrackerPower, Trackers, tracker_table
from studies.flight_logs.verdict import log_sentences, model_sentence, words_of

DEFAULT_MISSION = "rafz-28h"
# Time to either side [s]: the report's filters of 2 and 800 samples at its 2 Hz.
WINDOW_FILTER_S, DAY_FILTER_S = 1.0, 400.0
_ERRORS = (
    Column("model"),
    Column("modelled_mean_w", "mean", "W", ".2f"),
    Column("average_error_w", "average", "W", "+.2f"),
    Column("average_error_percent", "%", form="+.2f"),
    Column("rms_error_w", "RMS", "W", ".2f"),
    Column("rms_error_percent", "%", form=".2f"),
    Column("maximum_error_w", "maximum", "W", ".2f"),
    Column("maximum_error_percent", "%", form=".2f"),
)
# Of a large aircraft whole watts are enough, and 80 columns wide.
_MANY_W = 1000.0
_WHOLE_WATTS = tuple(
    replace(column, form=column.form.replace(".2f", ".0f" if column.unit == "W" else ".1f"))
    for column in _ERRORS
)


@dataclass(frozen=True, repr=False)
class Verification(Result):
    """Solar power models against a flight log.

    Attributes
    ----------
    craft : Aircraft
    mission : str
        Its name.
    log : FlightLog
        The flight, without the errors of clock, angles and unit that were certain.
    diagnosis : Diagnosis or None
        What the power says of log, modules and sky; None where that was not asked for.
    corrected : bool
        Whether errors of the log were corrected.
    whole : Section
        Errors over the whole log.
    samples : Samples
        Its samples with the sun up, and all models on them.
    excluded : ndarray of bool
        Samples with limited charging, which are in no error.
    windows, days : tuple of Section
        Errors in the windows that were asked for, and on each day (UTC).
    window_masks : tuple of ndarray of bool
        Samples of each window.
    window_filter_s, day_filter_s : float
        Time on either side in the moving averages [s].
    anomalies : tuple of Anomaly
        What looks wrong, in the order of time.
    notes : tuple of str
        What the reader should know.
    trackers : tuple of TrackerPower
        Power of each of several MPPTs beside that of its modules, without limited charging.
    matched : str
        How their modules are known.
    """

    craft: Aircraft
    mission: str
    log: FlightLog
    diagnosis: Diagnosis | None
    corrected: bool
    whole: Section
    samples: Samples
    excluded: BoolArray
    windows: tuple[Section, ...]
    window_masks: tuple[BoolArray, ...]
    days: tuple[Section, ...]
    day_filter_s: float
    window_filter_s: float
    anomalies: tuple[Anomaly, ...]
    notes: tuple[str, ...]
    trackers: tuple[TrackerPower, ...] = ()
    matched: str = ""

    @property
    def aircraft(self) -> str:
        """Name of the aircraft."""
        return self.craft.name

    @property
    def alignment(self) -> SimpleNamespace | None:
        """Errors of the log as ``to_dict`` has them; deprecated for :attr:`diagnosis`."""
        message = "Verification.alignment is deprecated: use diagnosis, or to_dict()['alignment']"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        known = self.diagnosis
        return None if known is None else SimpleNamespace(**self._alignment_record(known))

    def headline(self) -> str:
        """Aircraft, log and its length in one line."""
        start, end = utc_label(self.log.time_s[0]), utc_label(self.log.time_s[-1])
        return (
            f"{self.aircraft} against {self.log.source}: {start} to {end}, "
            f"{len(self.samples.time_s)} of {len(self.log)} samples with the sun up"
        )

    def summary(self) -> Summary:
        """Verdicts, errors of every window and day, anomalies, what the reader should know."""
        blocks: list[Any] = [Line(self.headline(), "strong")]
        for text, wrong in self.log_verdicts():
            blocks.append(Line(text, "warning" if wrong else "plain"))
        blocks += [*self.verdicts().values(), *self.tables()]
        if not any(a.severity != "normal" for a in self.anomalies):
            blocks.append("no anomaly found")
        if self.excluded.any():
            blocks.append(
                f"{self.excluded.sum()} samples with limited charging are not in the errors"
            )
        blocks += [f"- {note}" for note in self.notes]
        definition = (
            "errors are modelled minus measured, % of the mean measured power; RMS and maximum "
            "after a moving average over so many seconds to either side as filter says"
        )
        return Summary((*blocks, Line(definition, "faint")))

    def verdicts(self) -> dict[str, str]:
        """One sentence for each model."""
        return {
            model: model_sentence(model, self.whole.errors.get(model), self.whole.filter_s)
            for model in self.samples.modelled_w
        }

    def log_verdicts(self) -> list[tuple[str, bool]]:
        """Sentences on what may be wrong with log and modules, and whether each is an error."""
        if self.diagnosis is None:
            return []
        return list(log_sentences(self.diagnosis, self.craft, corrected=self.corrected))

    def tables(self) -> list[Table]:
        """Errors of every window and day, and the anomalies if there are any."""
        tables = [_error_table(section, "solar time") for section in self.windows]
        tables += [_error_table(section, "UTC") for section in self.days]
        if self.trackers:
            tables.append(tracker_table(self.trackers, self.matched))
        if self.anomalies:
            rows = [(a.kind.replace("_", " "), a.severity, _evidence(a)) for a in self.anomalies]
            columns = (Column("what"), Column("severity"), Column("evidence"))
            tables.append(Table("what stands out", columns, tuple(rows)))
        return tables

    def to_dict(self) -> dict[str, Any]:
        """Everything but the samples, JSON-ready."""
        log = self.log
        return {
            "aircraft": self.aircraft,
            "mission": self.mission,
            "log": {
                "source": log.source,
                **_span_record(log.time_s[0], log.time_s[-1]),
                "samples": len(log),
                "sunlit_samples": len(self.samples.time_s),
                "rows_read": log.rows_read,
                "rows_dropped": log.rows_dropped,
                "step_s": log.step_s,
                "gaps": [_span_record(gap.start_s, gap.end_s) for gap in log.gaps],
                "left_out": [_left_out_record(one) for one in log.left_out],
            },
            "alignment": None if self.diagnosis is None else self._alignment_record(self.diagnosis),
            "causes": [] if self.diagnosis is None else self._causes(self.diagnosis),
            "models": list(self.samples.modelled_w),
            "verdicts": self.verdicts(),
            "excluded_samples": int(self.excluded.sum()),
            "windows": [_section_record(section) for section in self.windows],
            "days": [_section_record(section) for section in self.days],
            "mppts": [one._asdict() for one in self.trackers],
            "anomalies": [_anomaly_record(anomaly) for anomaly in self.anomalies],
            "notes": list(self.notes),
        }

    def _alignment_record(self, diagnosis: Diagnosis) -> dict[str, Any]:
        clock, heading = diagnosis.clock, diagnosis.heading
        return {
            "power_unit": diagnosis.unit,
            "clock_ahead_s": None if clock is None else clock[0],
            "clock_sigma_s": None if clock is None else clock[1],
            "clock_wrong": diagnosis.named("clock_s"),
            "heading_ahead_deg": None if heading is None else float(np.degrees(heading[0])),
            "heading_sigma_deg": None if heading is None else float(np.degrees(heading[1])),
            "heading_wrong": diagnosis.named("heading"),
            "corrected": self.corrected,
            "notes": list(diagnosis.notes),
        }

    def _causes(self, diagnosis: Diagnosis) -> list[dict[str, Any]]:
        """Causes that were found, each with those that fit about as well."""
        return [
            {
                "cause": one.best.name,
                "size": one.best.size,
                "sigma": one.best.sigma,
                "text": words_of(one.best, self.craft),
                "battery": one.battery,
                "others": [
                    {"cause": o.name, "size": o.size, "text": words_of(o, self.craft)}
                    for o in one.others
                ],
            }
            for one in diagnosis.findings
        ]

    def to_frame(self) -> pd.DataFrame:
        """Samples with models and errors, one row each."""
        return pd.DataFrame({name: values for name, _, values in self._columns()})

    def to_csv(self) -> str:
        """Samples as CSV text; a data frame takes several times as long for a long flight."""
        names, formats, columns = zip(*self._columns(), strict=True)
        text = io.StringIO()
        rows = np.column_stack(columns)
        np.savetxt(text, rows, formats, delimiter=",", header=",".join(names), comments="")
        return text.getvalue()

    def _columns(self) -> Iterator[tuple[str, str, NDArray[Any]]]:
        """Name, format and values of each quantity of the samples."""
        samples, log = self.samples, self.log
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
        yield "excluded", "%d", self.excluded.astype(int)


def utc_label(time_s: float) -> str:
    """Universal time as ISO 8601, to the second."""
    return f"{utc_text(time_s).replace(' ', 'T')}Z"


def _span_record(start_s: float, end_s: float) -> dict[str, str]:
    return {"start": utc_label(start_s), "end": utc_label(end_s)}


def _left_out_record(one: LeftOut) -> dict[str, Any]:
    known = _span_record(one.periods[0][0], one.periods[-1][1]) if one.periods else {}
    return {"column": one.column, "kind": one.kind, "values": one.values, **known}


def _evidence(anomaly: Anomaly) -> str:
    span = " to ".join(utc_text(time_s) for time_s in (anomaly.start_s, anomaly.end_s))
    lost = f"; {anomaly.lost_wh:.1f} Wh lost" if anomaly.lost_wh else ""
    return f"{span} (UTC): {anomaly.evidence}{lost}"


def _anomaly_record(anomaly: Anomaly) -> dict[str, Any]:
    record = asdict(anomaly)
    return record | _span_record(record.pop("start_s"), record.pop("end_s"))


def _section_record(section: Section) -> dict[str, Any]:
    some = next(iter(section.errors.values()), None)
    return {
        "label": section.label,
        **_span_record(section.start_s, section.end_s),
        "samples": section.samples,
        "excluded_samples": section.excluded,
        "filter_s": section.filter_s,
        "measured_mean_w": None if some is None else some.measured_mean_w,
        "models": {m: _errors_record(e) for m, e in section.errors.items()},
    }


def _errors_record(errors: ModelErrors) -> dict[str, float | None]:
    record: dict[str, float | None] = {"modelled_mean_w": errors.modelled_mean_w}
    for name in ("average", "rms", "maximum"):
        error_w = getattr(errors, f"{name}_w")
        record[f"{name}_error_w"] = error_w
        record[f"{name}_error_relative"] = errors.relative(error_w)
    return record


def _error_table(section: Section, clock: str) -> Table:
    """Errors of all models in a window or on a day."""
    name = f"{section.label} ({clock})"
    if not section.errors:
        return Table(f"{name}: all samples are excluded", _ERRORS, ())
    rows = []
    for model, errors in section.errors.items():
        row: list[float | str | None] = [model, errors.modelled_mean_w]
        for error_w in (errors.average_w, errors.rms_w, errors.maximum_w):
            relative = errors.relative(error_w)
            row += [error_w, None if relative is None else 100.0 * relative]
        rows.append(tuple(row))
    measured = next(iter(section.errors.values())).measured_mean_w
    title = (
        f"{name}: {measured:.2f} W measured, {section.samples} samples, "
        f"filter {section.filter_s:g} s"
    )
    return Table(title, _ERRORS if measured < _MANY_W else _WHOLE_WATTS, tuple(rows))


def verify(
    aircraft: Aircraft,
    log: FlightLog | str | os.PathLike[str],
    mission: Mission | None = None,
    *,
    windows: Sequence[Window | str] = (),
    filter_s: float | None = None,
    shading: ShadedArea | None = None,
    correct: bool | None = True,
) -> Verification:
    """Compare all models with a log and look for anomalies.

    Parameters
    ----------
    aircraft : Aircraft
        Its modules; VM and FM need their geometry.
    log : FlightLog or path
        The flight, or its file (CSV, or PX4 ULog).
    mission : Mission, optional
        Clearness, and temperatures that the log does not have; the shipped ``rafz-28h`` by default.
    windows : sequence of Window or str
        Periods to report on apart from the days; texts as for :func:`parse_window`.
    filter_s : float, optional
        Time on either side in the moving average [s]; 1 s in windows and 400 s over days if not
        given.
    shading : callable, optional
        Shaded area instead of that of the aircraft's own tail.
    correct : bool or None
        Whether errors of the log that are certain are corrected before anything is compared; else
        they are told only. None: nothing is taken to be wrong.

    Returns
    -------
    Verification

    Raises
    ------
    ValueError
        If a text is no window.
    InputError
        If the log cannot be read, the sun never rises in it, or a window has no sample.
    """
    periods = [parse_window(w) if isinstance(w, str) else w for w in windows]
    log = log if isinstance(log, FlightLog) else read_flight_log(os.fspath(log))
    mission = load_mission(DEFAULT_MISSION) if mission is None else mission
    geometry, reasons = module_geometry(log, aircraft)
    trackers, reason = Trackers.of(log, geometry)
    reasons += [reason] if reason else []
    shade = shading
    if shade is None and geometry is not None:
        shade, unknown = tail_shading(aircraft, geometry)
        reasons += [unknown] if unknown else []
    forward = Forward(log, aircraft, mission, geometry, shade, np.arange(len(log)))
    diagnosis = diagnose(forward, trackers, search=correct is not None)
    error = diagnosis.correction if correct else LogError()
    log = log if error == LogError() else error.removed(log)
    try:
        samples, sources = lit_samples(replace(forward, log=log))
    except InputError as night:
        told = log_sentences(diagnosis, aircraft, corrected=False)
        reasons = [text for text, wrong in told if wrong and diagnosis.findings]
        raise file_error(log.source, "; ".join([night.problems[0].message, *reasons])) from None
    found = Anomalies(log, samples, diagnosis, aircraft, error.clock_s)
    limited = found.excluded()
    compared = replace(forward, log=log, index=samples.index[~limited])
    masks = tuple(in_window(samples, window) for window in periods)
    for window, mask in zip(periods, masks, strict=True):
        if not mask.any():
            message = f"no sample with the sun up lies in the window {window.label} (solar time)"
            raise file_error(log.source, f"{message}; allowed: {solar_span(samples)}")
    window_s = WINDOW_FILTER_S if filter_s is None else filter_s
    day_s = DAY_FILTER_S if filter_s is None else filter_s
    labelled = zip([window.label for window in periods], masks, strict=True)
    return Verification(
        craft=aircraft,
        mission=mission.name,
        log=log,
        diagnosis=None if correct is None else diagnosis,
        corrected=error != LogError(),
        whole=sections(samples, limited, day_s, [("all", np.ones(len(limited), bool))])[0],
        samples=samples,
        excluded=limited,
        windows=sections(samples, limited, window_s, labelled),
        window_masks=masks,
        days=sections(samples, limited, day_s, day_masks(samples)),
        day_filter_s=day_s,
        window_filter_s=window_s,
        anomalies=tuple(found.every()),
        trackers=() if trackers is None else trackers.compared(compared),
        matched="" if trackers is None else trackers.how,
        notes=(*log.notes, *reasons, *sources),
    )
