"""Truth against verdict on flight logs of an independent simulation.

``python -m benchmarks.log_causes`` prints the table of ``docs/verify.md``, of logs that were not
looked at while the causes were tuned; ``--tuning`` those that were, ``--seeds`` other series,
``--clean`` only the logs without fault, ``--by-side`` modules and clean logs with a column for the
MPPT of each side of the wing.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import Pool
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.independent_logs import HOLD_OUT, TRUTHS, TUNING, Truth, made
from missions.library import load_mission
from missions.logs.csv import read_flight_log
from sizing.library import load_aircraft
from studies.flight_logs.verification import Verification, verify

# Aims: shares of right causes named first, of wrong blames and of false alarms; errors of clock
# [s] and heading [deg] where they are the truth.
LEAST_RIGHT, MOST_WRONG, MOST_FALSE = 0.9, 0.02, 0.02
CLOCK_S, HEADING_DEG = 120.0, 3.0


@dataclass(frozen=True)
class Case:
    """A truth, and what was said of it."""

    number: int
    truth: Truth
    said: tuple[str, ...]  # causes of the first finding, the likeliest first
    more: tuple[str, ...]  # causes of further findings
    error: float | None  # of clock [s] or heading [deg], where that is the truth
    text: str
    # Errors of clock and heading over their stated standard deviation, where they should be known.
    clock_z: float | None = None
    heading_z: float | None = None

    @property
    def expected(self) -> str:
        """Name of the true cause."""
        return NAMES.get(self.truth.cause, self.truth.cause)

    @property
    def right(self) -> bool:
        """Whether the true cause is named first and nothing else is blamed."""
        first = self.said[0] if self.said else "nothing"
        return first == self.expected and not self.more

    @property
    def wrong(self) -> bool:
        """Whether something is blamed and the true cause is not among it."""
        return self.blames and (self.expected not in self.said or bool(self.more))

    @property
    def blames(self) -> bool:
        """Whether anything is blamed: what is said of the sky or a full battery accuses nobody."""
        return bool(self.more) or (bool(self.said) and self.said[0] not in NO_BLAME)


_HELD = {"saturated": "saturation"}  # names of what is left out before causes are fitted
NO_BLAME = ("sky", "battery full")
NAMES = {
    "roll_sign": "sign of roll",
    "pitch_sign": "sign of pitch",
    "yaw_sign": "sign of yaw",
    "longitude_sign": "sign of longitude",
    "power_loss": "power loss",
    "power_sign": "sign of power",
}


def judged(number: int, seed: int, by_side: bool = False) -> Case:
    """Fly, verify and compare with the truth."""
    warnings.simplefilter("ignore")  # ranges of the models, which are not the subject
    truth, aircraft = TRUTHS[number], load_aircraft("atlantiksolar-as2")
    rows = made(aircraft, truth, seed + number, by_side=by_side).rows
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{seed + number}.csv"
        rows.to_csv(file, index=False)
        log = read_flight_log(file)
    result = verify(aircraft, log, load_mission("rafz-28h"))
    named = [*_said(result), ()]
    said, more = named[0], named[1:]
    blamed = [names for names in more if names and names[0] not in NO_BLAME]
    others = tuple(name for names in blamed for name in names)
    texts = [text for text, wrong in result.log_verdicts() if wrong or "sky" in text]
    error, z = _error(result, truth), _in_sigmas(result, truth)
    return Case(number, truth, said, others, error, " | ".join(texts), *z)


def _said(result: Verification) -> Iterator[tuple[str, ...]]:
    """Causes that are blamed, each with those that fit as well."""
    diagnosis = result.diagnosis
    assert diagnosis is not None
    if diagnosis.unit != "W":
        yield ("unit",)
    if diagnosis.factor < 0.0:
        yield ("sign of power",)
    held = {_HELD.get(one.kind, one.kind) for one in result.log.left_out}
    yield from ((name,) for name in sorted(held))
    if diagnosis.sky is not None and not diagnosis.findings:
        yield ("sky",)
    for finding in diagnosis.findings:
        names = tuple(one.name for one in (finding.best, *finding.others))
        if finding.best.name not in held:  # said already
            yield ("battery full", *names) if finding.normal else names


def _error(result: Verification, truth: Truth) -> float | None:
    """Error of the clock [s] or the heading [deg] where that is the truth and is found."""
    assert result.diagnosis is not None
    clock, heading = result.diagnosis.clock, result.diagnosis.heading
    if truth.cause == "clock" and clock is not None:
        return clock[0] - 60.0 * truth.size
    if truth.cause == "heading" and heading is not None:
        return float((np.degrees(heading[0]) - truth.size + 180.0) % 360.0 - 180.0)
    return None


def _in_sigmas(result: Verification, truth: Truth) -> tuple[float | None, float | None]:
    """Errors of clock and heading over their standard deviations, where nothing else is wrong."""
    found = result.diagnosis
    if found is None or truth.cause not in ("nothing", "clock", "heading"):
        return None, None
    clock = 60.0 * truth.size if truth.cause == "clock" else 0.0
    turned = np.radians(truth.size) if truth.cause == "heading" else 0.0
    turn = None if found.heading is None else (found.heading[0] - turned + np.pi) % (2.0 * np.pi)
    return (
        None if found.clock is None else (found.clock[0] - clock) / found.clock[1],
        None if found.heading is None or turn is None else (turn - np.pi) / found.heading[1],
    )


def every(
    seed: int, numbers: Sequence[int] | None = None, workers: int = 1, *, by_side: bool = False
) -> list[Case]:
    """All logs from a seed on, or some of them."""
    chosen = range(len(TRUTHS)) if numbers is None else numbers
    jobs = [(number, seed, by_side) for number in chosen]
    if workers == 1:
        return [judged(*job) for job in jobs]
    with Pool(workers) as pool:
        return pool.starmap(judged, jobs, chunksize=1)


def rates(cases: Sequence[Case]) -> dict[str, float]:
    """Shares that the aims are about."""
    faulty = [one for one in cases if one.truth.cause != "nothing"]
    clean = [one for one in cases if one.truth.cause == "nothing"]
    clocks = [abs(c.error) for c in faulty if c.truth.cause == "clock" and c.error is not None]
    headings = [abs(c.error) for c in faulty if c.truth.cause == "heading" and c.error is not None]
    return {
        "right cause first": _mean([one.right for one in faulty]),
        "wrong blame": _mean([one.wrong for one in faulty]),
        "false alarms": _mean([one.blames for one in clean]),
        "clocks within 2 min": _share(clocks, CLOCK_S),
        "headings within 3 deg": _share(headings, HEADING_DEG),
    }


def _share(errors: Sequence[float], most: float) -> float:
    return _mean([one <= most for one in errors])


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def in_sigmas(cases: Sequence[Case]) -> dict[str, float]:
    """RMS of the errors of clock and heading over their stated standard deviations: one is aim."""
    every_z = {
        "clock": [one.clock_z for one in cases if one.clock_z is not None],
        "heading": [one.heading_z for one in cases if one.heading_z is not None],
    }
    return {name: _mean([z**2 for z in some]) ** 0.5 for name, some in every_z.items()}


def table(cases: Sequence[Case]) -> str:
    """Truth against verdict as a table in Markdown."""
    rows: dict[str, Counter[str]] = {}
    for one in cases:
        full = ", battery full" if one.truth.full and one.truth.cause == "nothing" else ""
        said = " or ".join(one.said) or "nothing"
        rows.setdefault(one.expected + full, Counter())[said] += 1
    lines = ["| truth | logs | verdict |", "|---|---|---|"]
    for truth, counts in rows.items():
        verdicts = "; ".join(f"{name} ({count})" for name, count in counts.most_common())
        lines.append(f"| {truth} | {counts.total()} | {verdicts} |")
    return "\n".join(lines)


def main() -> None:
    """Print tables and rates."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tuning", action="store_true")
    parser.add_argument("--seeds", type=int, nargs="+", help="first seeds of series")
    parser.add_argument("--clean", action="store_true")
    parser.add_argument("--by-side", action="store_true")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--each", action="store_true", help="print every log")
    options = parser.parse_args()
    causes = {one.cause for one in TRUTHS}
    if options.by_side:
        causes = {"nothing", "modules"}
    if options.clean:
        causes = {"nothing"}
    numbers = [i for i, one in enumerate(TRUTHS) if one.cause in causes]
    for seed in options.seeds or (TUNING if options.tuning else (HOLD_OUT,)):
        cases = every(seed, numbers, options.workers, by_side=options.by_side)
        print(f"\nseeds from {seed}: {len(cases)} logs\n\n{table(cases)}\n")
        for what, share in rates(cases).items():
            print(f"{what}: {100.0 * share:.1f} %")
        for what, size in in_sigmas(cases).items():
            print(f"error of the {what} over its standard deviation, RMS: {size:.2f}")
        for one in cases:
            if options.each or not (one.right or (one.expected == "nothing" and not one.said)):
                print(f"{one.number:3d} {one.truth}: {one.said} {one.more} {one.error} {one.text}")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
