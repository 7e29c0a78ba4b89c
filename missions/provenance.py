"""Where the numbers of a file come from: what was fitted to which flight, and how well.

A command writes the block; readers keep it and compute nothing from it.
"""

from __future__ import annotations

from solar.schema import Name, Real, Record, Text


class FittedValue(Record):
    """A value that was fitted, with the ends of its confidence interval, in the unit of its key."""

    key: Name
    value: Real
    before: Real
    standard_error: Real
    low: Real
    high: Real


class HeldValue(Record):
    """A value that was to be fitted and stayed as it was, and why."""

    key: Name
    value: Real
    reason: Text


class LogFile(Record):
    """A further log that was fitted together with the first, or the file of a bench test."""

    log: Text
    sha256: Text


class Provenance(Record):
    """Command, date and files that a file was made of, and what was fitted.

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
