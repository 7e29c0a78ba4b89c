"""Solar power models against a flight log: errors, residuals, estimates, and samples left out.

Nothing is judged or corrected; offsets are subtracted from the log on request.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from missions.library import load_mission
from missions.logs.csv import read_flight_log
from missions.logs.plausible import span_text
from missions.logs.table import FlightLog, Gap
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.results.result import Result
from solar.schema import spell
from solar.types import BoolArray, FloatArray
from studies.flight_logs.errors import (
    MpptPower,
    MpptPowers,
    Section,
    Window,
    compare_mppts,
    filtered,
    in_windows,
    on_days,
    parse_window,
    residual_tables,
    residuals,
    sections,
    surfaces_of,
)
from studies.flight_logs.estimates import CONFIDENCE, LABELS, Applied, Estimate, estimates
from studies.flight_logs.forward import Forward, Samples, daylight_samples
from studies.flight_logs.left_out import Stretch, fit_and_left_out
from studies.quantities import group
from studies.render.tables import ALL, Column, Line, Table
from studies.render.words import amount
from studies.serialise import utc

DEFAULT_MISSION = "rafz-28h"
# Time to either side [s]: the report's filters of 2 and 800 samples at its 2 Hz.
WINDOW_FILTER_S, DAY_FILTER_S = 1.0, 400.0
_ERRORS = group(
    "model modelled_mean_w average_error_w average_error_percent rms_error_w rms_error_percent "
    "maximum_error_w maximum_error_percent"
)
# Whole watts are enough for a large aircraft, and fit into 80 columns.
_MANY_W = 1000.0
_WHOLE_WATTS = tuple(
    replace(column, form=column.form.replace(".2f", ".0f" if column.unit == "W" else ".1f"))
    for column in _ERRORS
)
_DECIMALS = 5  # of hours: a twentieth of a second


@dataclass(frozen=True, repr=False)
class Verification(Result):
    """Solar power models against a flight log.

    ``log``: without the offsets ``applied``. ``excluded``: flags of samples left out of errors,
    residuals and estimates; ``left_out``: stretches with reasons. ``correlation``: of the errors of
    clock and heading. ``rms_w``: RMS error of the most detailed model as logged and with the
    estimates. ``estimated_w``: power with the estimated clock, heading and factor. ``days``,
    ``windows``: errors of all models. ``mppts``: measured and modelled power of several MPPTs.
    """

    aircraft: str
    mission: str
    log: FlightLog
    applied: Applied
    samples: Samples
    excluded: BoolArray
    left_out: tuple[Stretch, ...]
    estimates: tuple[Estimate, ...]
    correlation: float | None
    rms_w: tuple[float | None, float | None]
    estimated_w: FloatArray | None
    residuals: Mapping[str, pd.DataFrame]
    windows: tuple[Section, ...]
    days: tuple[Section, ...]
    notes: tuple[str, ...]
    mppts: MpptPowers | None = None

    def overview(self) -> Table:
        """Return a table of the most detailed model's errors by window and day."""
        model, columns = self.samples.best_model, (*group("period"), *_ERRORS[1:])
        rows = [
            (section.label, *_error_cells(section.models[model]))
            for section in (*self.windows, *self.days)
            if model in section.models
        ]
        title = f"errors of {model}, modelled minus measured, % of the mean measured"
        return Table(title, columns, tuple(rows))

    def estimates_table(self, level: int = ALL) -> Table:
        """Return a table of clock, heading and powers."""
        notes = []
        if None not in self.rms_w:
            text = "RMS error of {} {:.1f} W as logged, {:.1f} W with clock, heading and factor"
            notes = [text.format(self.samples.best_model, *self.rms_w)]
        notes += [f"{LABELS[e.name][0]}: {e.why}" for e in self.estimates if e.why]
        if self.correlation is not None and level >= ALL:
            text = f"correlation of clock and heading {self.correlation:+.2f}: where one is wrong, "
            notes.append(f"{text}so is the other; roll and pitch are taken to be right to 0.5 deg")
        columns = (
            Column("estimate"),
            Column("value", to_right=True),
            Column("interval", f"{CONFIDENCE:.0%} interval", to_right=True),
        )
        rows = tuple(estimate.texts() for estimate in self.estimates)
        return Table("estimates, none of them applied", columns, rows, notes=tuple(notes))

    def tables(self) -> list[Table]:
        """Return tables of errors, estimates, residuals and stretches left out."""
        tables = []
        for section in (*self.windows, *self.days):
            name, measured = f"{section.label} ({section.clock})", section.measured_mean_w
            if measured is None:
                tables.append(Table(f"{name}: all samples are excluded", _ERRORS, ()))
                continue
            columns = _ERRORS if measured < _MANY_W else _WHOLE_WATTS
            rows = [(model, *_error_cells(errors)) for model, errors in section.models.items()]
            count = f"{section.samples} samples, filter {spell(section.filter_s)} s"
            title = f"{name}: {amount(measured, 'W', '.2f')} measured, {count}"
            tables.append(Table(title, columns, tuple(rows)))
        tables.append(self.estimates_table())
        tables += residual_tables(self.residuals, self.samples.best_model)
        tables += [] if self.mppts is None else [self.mppts.table()]
        if self.left_out:
            why = (Column("why"), Column("UTC"), Column("evidence"))
            left = (
                (s.reason.replace("_", " "), span_text(s.start_s, s.end_s), s.evidence)
                for s in self.left_out
            )
            tables.append(Table("left out", why, tuple(left)))
        return tables

    @property
    def estimates_by_name(self) -> dict[str, Estimate]:
        """Estimates by their names."""
        return {estimate.name: estimate for estimate in self.estimates}

    @property
    def each_mppt(self) -> tuple[MpptPower, ...]:
        """Measured and modelled power of every MPPT, where they are compared."""
        return () if self.mppts is None else self.mppts.each

    @property
    def residual_rows(self) -> dict[str, list[dict[str, Any]]]:
        """Residuals as records, those by time with the ends of their bins as texts."""
        rows: dict[str, Any] = {n: bins.to_dict("records") for n, bins in self.residuals.items()}
        rows["time"] = [
            {"start": utc(row.pop("low")), "end": utc(row.pop("high"))} | row
            for row in rows["time"]
        ]
        return rows

    def to_frame(self) -> pd.DataFrame:
        """Return a row per sample with models and errors."""
        samples, log = self.samples, self.log
        columns = {
            "time_utc_s": samples.time_s,
            "time_solar_h": samples.time_solar_h,
            "sun_elevation_deg": samples.elevation_deg,
        }
        if log.attitude is not None:
            columns["sun_bearing_deg"] = samples.bearing_deg
        columns["solar_power_w"] = samples.measured_w
        powers = samples.modelled_w.items()
        columns |= {f"{model.lower()}_w": power for model, power in powers}
        columns |= {
            f"{model.lower()}_error_w": power - samples.measured_w for model, power in powers
        }
        columns |= samples.detail
        if log.mppt_voltage_v is not None:
            columns["mppt_voltage_v"] = log.mppt_voltage_v[samples.index]
        return pd.DataFrame(columns).assign(excluded=self.excluded.astype(int))

    def to_csv(self) -> str:
        """Return the samples as CSV text."""
        return str(self.to_frame().round(_DECIMALS).to_csv(index=False))


def headline(verification: Verification) -> str:
    """Return aircraft, log and its length in one line."""
    start, end = utc(verification.log.time_s[0]), utc(verification.log.time_s[-1])
    return (
        f"{verification.aircraft} against {verification.log.source}: {start} to {end}, "
        f"{len(verification.samples.time_s)} of {len(verification.log)} samples with the sun up"
    )


def blocks(verification: Verification, level: int) -> list[Any]:
    """Return errors and estimates, with all models and residuals at the last level."""
    shown: list[Any] = [Line(headline(verification), "strong")]
    units = zip(("clock", "heading"), verification.applied, ("min", "deg"), strict=True)
    if taken := [f"{name} offset of {spell(by)} {unit}" for name, by, unit in units if by]:
        shown.append(f"compared without a {' and a '.join(taken)}, as asked for")
    shown += (
        verification.tables()
        if level >= ALL
        else [verification.overview(), verification.estimates_table(level)]
    )
    if options := [
        " ".join(estimate.apply) for estimate in verification.estimates if estimate.apply
    ]:
        shown += ["to apply an estimate, add its option:", *options]
    if verification.excluded.any():
        shown.append(f"{verification.excluded.sum()} samples are left out of errors and residuals")
    if level < ALL:
        return shown
    shown += [f"- {note}" for note in verification.notes]
    definition = (
        "errors are modelled minus measured, % of the mean measured power; RMS and maximum "
        "after a moving average over so many seconds to either side as filter says; estimated: "
        "with clock, heading and factor on power as estimated"
    )
    return [*shown, Line(definition, "faint")]


def _error_cells(errors: Mapping[str, Any]) -> Iterator[float | None]:
    """Yield errors in watts and in per cent."""
    for key, error in errors.items():
        yield 100.0 * error if error is not None and key.endswith("relative") else error


def verify(
    aircraft: Aircraft,
    log: FlightLog | str | os.PathLike[str],
    mission: Mission | None = None,
    *,
    windows: Sequence[Window | str] = (),
    filter_s: float | None = None,
    clock_offset_min: float = 0.0,
    heading_offset_deg: float = 0.0,
) -> Verification:
    """Compare all models with a log, and estimate its clock, heading and powers.

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
    clock_offset_min : float
        Time that the log's clock is ahead of universal time [min], which is taken off.
    heading_offset_deg : float
        Angle that the log's yaw is too large [deg], which is taken off.

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
    if clock_offset_min or heading_offset_deg:
        ahead_s, attitude = 60.0 * clock_offset_min, log.attitude
        if attitude is not None:
            yaw_rad = attitude.yaw_rad - np.radians(heading_offset_deg)
            attitude = attitude._replace(yaw_rad=yaw_rad)
        log = replace(
            log,
            time_s=log.time_s - ahead_s,
            attitude=attitude,
            gaps=tuple(Gap(gap.start_s - ahead_s, gap.end_s - ahead_s) for gap in log.gaps),
            left_out=tuple(
                o._replace(periods=tuple((a - ahead_s, b - ahead_s) for a, b in o.periods))
                for o in log.left_out
            ),
        )
    forward = Forward(log, aircraft, mission, np.arange(len(log)))
    wiring, how = surfaces_of(log, forward.geometry)
    samples, remarks = daylight_samples(forward)
    fit, stretches, excluded = fit_and_left_out(forward, samples)
    inside = list(in_windows(samples, periods, log.source))
    window_s = WINDOW_FILTER_S if filter_s is None else filter_s
    day_s = DAY_FILTER_S if filter_s is None else filter_s
    daylight, applied = forward.of(samples.index), Applied(clock_offset_min, heading_offset_deg)
    estimated = None if fit is None else fit.applied_w(daylight)

    def rms_w(modelled_w: FloatArray | None) -> float | None:
        if modelled_w is None or excluded.all():
            return None
        _, smooth = filtered(samples, excluded, day_s, modelled_w)
        return float(np.sqrt(np.mean(smooth**2)))

    return Verification(
        aircraft=aircraft.name,
        mission=mission.name,
        log=log,
        applied=applied,
        samples=samples,
        excluded=excluded,
        left_out=tuple(sorted(stretches, key=lambda stretch: stretch.start_s)),
        estimates=estimates(forward, samples.index, fit, applied),
        correlation=None if fit is None else fit.correlation,
        rms_w=(rms_w(samples.modelled_w[samples.best_model]), rms_w(estimated)),
        estimated_w=estimated,
        residuals=residuals(samples, ~excluded, estimated),
        windows=sections(samples, excluded, window_s, "solar time", inside),
        days=sections(samples, excluded, day_s, "UTC", on_days(samples)),
        mppts=None if wiring is None else compare_mppts(daylight, wiring, how, ~excluded),
        notes=(*log.notes, *([how] if how and wiring is None else []), *remarks),
    )
