"""Provenance of a file's numbers: what was fitted to which flight, and how well.

A command writes the block; readers keep it and compute nothing from it.
"""

from __future__ import annotations

from solar.schema import Name, Real, Record, Text


class FittedValue(Record):
    """Fitted value with its confidence interval, in the unit of its key."""

    key: Name
    value: Real
    before: Real
    standard_error: Real
    low: Real
    high: Real


class HeldValue(Record):
    """Value that a fit kept, and why."""

    key: Name
    value: Real
    reason: Text


class LogFile(Record):
    """Further log of the same fit, or the file of a bench test."""

    log: Text
    sha256: Text


class Provenance(Record):
    """Command, date and source files of a file, and what was fitted.

    ``aircraft`` is the aircraft's file before, ``technology`` that of the technology it was
    calibrated with; checksums are SHA-256.
    """

    tool: Text
    date: Text
    aircraft: Text
    aircraft_sha256: Text | None = None
    log: Text | None = None
    log_sha256: Text | None = None
    more_logs: tuple[LogFile, ...] = ()
    bench_tests: tuple[LogFile, ...] = ()
    technology: Text | None = None
    technology_sha256: Text | None = None
    mission: Text | None = None
    confidence: Real | None = None
    light_sigma: Real | None = None
    fitted: tuple[FittedValue, ...] = ()
    held: tuple[HeldValue, ...] = ()
