"""Runs the commands of pages anew and writes what they print into the pages.

``python docs/replay.py docs/cli.md ...``, or without pages for all of them. Lines that a page
leaves out with ``...`` stay left out. What needs a person is listed, and the exit code is then 1:
outputs that cannot be told apart any more, and ``<!-- printed: ... -->`` whose numbers moved.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

from documented import (  # noqa: E402
    BOX_DRAWING,
    ELLIPSIS_LINE,
    NUMBER,
    PAGES,
    VARIES,
    blocks,
    disagreement,
    not_printed,
)
from played import SOLAR_UAV, Streams, in_subprocess, is_run, played  # noqa: E402

# Share of the lines of a claim that must stand in the output, numbers aside.
_ENOUGH = 0.6


def masked(line: str) -> str:
    """A line without its numbers, spaces and lines of tables."""
    return re.sub(r"\s+", "", NUMBER.sub("#", BOX_DRAWING.sub("", line.replace("−", "-"))))


def _found(claim: list[str], output: list[str], starts: range) -> int | None:
    """Where the lines of a claim begin in the output, the likeliest place first in order."""
    wanted = [masked(line) for line in claim]
    there = [masked(line) for line in output]
    alike = {
        start: sum(a == b for a, b in zip(wanted, there[start:], strict=False)) for start in starts
    }
    best = max(alike, key=lambda start: (alike[start], -start), default=None)
    return best if best is not None and alike[best] >= _ENOUGH * len(claim) else None


def renewed(claimed: str, printed: str) -> str | None:
    """The claim with what is printed now, or ``None`` if it cannot be aligned."""
    parts = [part.split("\n") for part in re.split(r"^\.\.\.$", claimed, flags=re.M)]
    output = [line.rstrip() for line in printed.rstrip("\n").split("\n")]
    whole = len(parts) == 1
    if whole:
        return "\n".join(_varying_left_out(output))
    position, new = 0, []
    for number, part in enumerate(parts):
        # A part begins and ends beside the line that stands for what is left out.
        lines = part[number > 0 : len(part) - (number < len(parts) - 1)]
        last = number == len(parts) - 1
        if lines:
            starts = range(position, len(output) - len(lines) + 1)
            if number == 0:
                starts = starts[:1]
            elif last:
                starts = starts[-1:]
            start = _found(lines, output, starts)
            if start is None:
                return None
            position = start + len(lines)
            new += _varying_left_out(output[start:position])
        if not last:
            new.append(ELLIPSIS_LINE)
    return "\n".join(line for i, line in enumerate(new) if new[i - 1 : i + 1] != ["...", "..."])


def _varying_left_out(lines: Sequence[str]) -> list[str]:
    return [ELLIPSIS_LINE if VARIES.search(line) else line for line in lines]


def call(words: list[str], variables: dict[str, str]) -> Streams:
    """Run the command as it is installed."""
    return in_subprocess([*SOLAR_UAV, *words], variables=variables)


def replay(page: Path, made_in: Path) -> Iterator[str]:
    """Run a page in the current folder and write it anew; what needs a person."""
    Path("docs/images").mkdir(parents=True)
    edits: list[tuple[int, str, str]] = []
    for block in filter(is_run, blocks(page)):
        printed = ""
        for done in played(block, call, made_in):
            at = f"{block}: {done.command.text.strip()}"
            both = done.out + done.err
            printed += both
            if done.code != block.exit_code:
                yield f"{at}\n  exit code {done.code}: {done.err[-400:]}"
                continue
            claimed = done.command.claimed
            if not claimed or any(claimed_in(claimed, text) for text in (done.out, both)):
                continue
            new = renewed(claimed, done.out) or renewed(claimed, both)
            if new is None:
                yield f"{at}\n  cannot be aligned; printed:\n{both}"
                continue
            edits.append((block.line, claimed, new))
            if masked(claimed.replace("\n", "")) != masked(new.replace("\n", "")):
                yield f"{at}\n  words changed, not only numbers"
        for text in not_printed(block, printed):
            yield f"{block}: not printed: {text}\n  now: {' | '.join(likely(text, printed))}"
    rewrite(page, edits)


def claimed_in(claimed: str, printed: str) -> bool:
    """Whether an output is what the page claims, and the page claims nothing that varies."""
    return disagreement(claimed, printed) is None and VARIES.search(claimed) is None


def likely(text: str, printed: str) -> list[str]:
    """Places of an output that are a text but for its numbers."""
    words = (r"[-+]?[\d.]+" if NUMBER.fullmatch(word) else re.escape(word) for word in text.split())
    return [" ".join(m[0].split()) for m in re.finditer(r"[\s\u2500-\u257f]+".join(words), printed)]


def rewrite(page: Path, edits: list[tuple[int, str, str]]) -> None:
    """Replace claims by what is printed, each the first one below its line and the last edit."""
    text = page.read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    places: list[tuple[int, int, str]] = []
    for line, claimed, new in edits:
        below = max(len("".join(lines[:line])) - 1, places[-1][1] if places else 0)
        at = text.index(f"\n{claimed}\n", below) + 1
        places.append((at, at + len(claimed), new))
    for start, end, new in reversed(places):
        text = text[:start] + new + text[end:]
    page.write_text(text, encoding="utf-8")


def main(names: Sequence[str]) -> int:
    """Replay the pages of the arguments."""
    pages = [Path(name).resolve() for name in names] or PAGES
    needs_person = False
    with tempfile.TemporaryDirectory() as made_in:
        for page in pages:
            print(f"== {page.relative_to(ROOT)}", flush=True)
            with tempfile.TemporaryDirectory() as folder:
                os.chdir(folder)
                for problem in replay(page, Path(made_in)):
                    print(problem, flush=True)
                    needs_person = True
                os.chdir(ROOT)
    return int(needs_person)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
