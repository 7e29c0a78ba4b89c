"""Intervals of ``verify`` on simulated flights of known truth.

    python -m benchmarks.log_estimates --seed 9100 --count 24

The flights are those of :mod:`benchmarks.independent_logs`: clean, with a battery that fills up, a
clock that is 37 min ahead, a heading that is 8 deg too large. Printed is in how many the interval
of 95 % holds the truth, and the RMS of the error over its standard error.
"""

from __future__ import annotations

import argparse
from collections import defaultdict

import numpy as np

from benchmarks.independent_logs import Truth, made
from missions.logs.table import log_from_table
from sizing.library import load_aircraft
from studies.flight_logs.estimates import WIDE
from studies.flight_logs.verification import verify

TRUTHS = (Truth(), Truth(full=True), Truth("clock", 37.0), Truth("heading", 8.0))


def main() -> None:
    """Print the coverage of a series."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=9100)
    parser.add_argument("--count", type=int, default=24)
    given = parser.parse_args()
    aircraft, errors = load_aircraft("atlantiksolar-as2"), defaultdict(list)
    for number in range(given.count):
        truth = TRUTHS[number % len(TRUTHS)]
        rows = made(aircraft, truth, given.seed + number).rows
        clock, heading, *_ = verify(aircraft, log_from_table(rows, "simulated")).estimates
        for name, one in (("clock", clock), ("heading", heading)):
            if one.value is not None and one.high is not None:
                error = one.value - (truth.size if truth.cause == name else 0.0)
                errors[name, truth.full].append(WIDE * error / (one.high - one.value))
    for (name, full), scaled in errors.items():
        inside = int(np.sum(np.abs(scaled) <= WIDE))
        rms = float(np.sqrt(np.mean(np.square(scaled))))
        print(f"{name}{', battery full' * full}: {inside} of {len(scaled)}, RMS {rms:.2f}")


if __name__ == "__main__":
    main()
