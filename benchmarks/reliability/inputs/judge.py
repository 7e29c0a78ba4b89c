"""Whether what a command did is what it may do, whatever it was given."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable
from pathlib import Path

from benchmarks.reliability.inputs.cases import Case

__all__ = ["Outcome", "mistake"]

# A name of a file may be anything: a number that is none stands by itself.
_NO_NUMBER = re.compile(r"(?<![\w.'/-])[-+]?(?:nan|inf|infinity)(?![\w.'/-])", re.IGNORECASE)
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
_LONGEST_MESSAGE = 12_000
_ENDS = {".svg": b"</svg>", ".html": b"</html>", ".pdf": b"%%EOF", ".png": b"IEND\xaeB`\x82"}


class Outcome:
    """What came out of a call.

    Parameters
    ----------
    code : int
        Exit code.
    printed, told : str
        Standard output and standard error.
    """

    def __init__(self, code: int, printed: str, told: str) -> None:
        self.code, self.printed, self.told = code, printed, told


def mistake(case: Case, outcome: Outcome, before: Iterable[str], folder: Path) -> str | None:
    """What is wrong with the outcome of a case; None where nothing is.

    Parameters
    ----------
    case : Case
    outcome : Outcome
    before : iterable of str
        Files of the folder before the call.
    folder : Path
        Folder of the call.

    Returns
    -------
    str or None
    """
    code, told = outcome.code, outcome.told
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if "Traceback" in told or "Traceback" in outcome.printed:
        return "traceback printed: " + told.strip().splitlines()[-1][:100]
    if "Warning: " in told:
        line = next(line for line in told.splitlines() if "Warning: " in line)
        return f"warning of a library printed: {line.strip()[-160:]}"
    if (
        code and not (told + outcome.printed).strip() and not case.environment
    ):  # a shell wants no words
        return f"exit code {code} without a word"
    if len(told) > _LONGEST_MESSAGE:
        return f"message of {len(told)} characters"
    if not case.environment and (odd := _CONTROL.search(outcome.printed + told)):
        return f"control character {odd.group()!r} printed"
    return _wrong_result(case, outcome) or _wrong_files(case, outcome, set(before), folder)


def _wrong_result(case: Case, outcome: Outcome) -> str | None:
    if outcome.code:
        return None
    if case.json:
        try:
            json.loads(outcome.printed, parse_constant=_refused)
        except ValueError as error:
            return f"no strict JSON: {error}"
        return None
    spoken = outcome.printed + outcome.told
    if case.arguments[:1] not in (("show",), ("validate",)) and (odd := _NO_NUMBER.search(spoken)):
        at = spoken.rfind("\n", 0, odd.start()) + 1
        return f"prints {odd.group()} as a result: {spoken[at : at + 90].strip()}"
    return None


def _refused(name: str) -> float:
    raise ValueError(f"{name} in it")


def _wrong_files(case: Case, outcome: Outcome, before: set[str], folder: Path) -> str | None:
    code, printed = outcome.code, outcome.printed.strip()
    after = {str(p.relative_to(folder)) for p in folder.rglob("*") if not p.is_dir()}
    made = after - before
    kept = ("lock", ".part") if "--keep-parts" in case.arguments else ()
    left = [name for name in made if name.endswith((".tmp", ".scratch", ".part", "lock"))]
    if left := [name for name in left if not name.endswith(kept)]:
        return f"leaves {left[0]} behind"
    if code == 2 and made:
        return f"refused, but wrote {sorted(made)[0]}"
    if "outside.txt" in before and (folder / "outside.txt").read_bytes() != b"untouched":
        return "a file outside of the folder of results was changed"
    if before - after:
        return f"removed {sorted(before - after)[0]}"
    # Without a result; "never perpetual" is one, with exit code 1.
    if code and not printed:
        return f"failed, but wrote {sorted(made)[0]}" if made & set(case.outputs) else None
    for name in case.outputs:
        if name in made and (wrong := _wrong_content(folder / name)):
            return f"{name}: {wrong}"
    return None


def _wrong_content(path: Path) -> str | None:
    content = path.read_bytes()
    end = _ENDS.get(path.suffix)
    if end is not None and not content.rstrip().endswith(end):
        return "ends amid its content"
    if path.suffix != ".csv":
        return None
    lines = [line for line in content.decode().splitlines() if not line.startswith("# {")]
    rows = list(csv.reader(lines))  # trade studies tell in a comment what they are of
    if len({len(row) for row in rows}) != 1:
        return "rows of different lengths"
    for row in rows[1:]:
        for name, cell in zip(rows[0], row, strict=True):
            if cell.startswith(("=", "@", "\t", "\r")) or re.match(r"[-+][^\d.]", cell):
                return f"formula {cell[:40]!r}"
            # The endurance of perpetual flight has no end.
            if cell.lower().lstrip("-+") in ("inf", "infinity") and "endurance" not in name:
                return f"{cell} as a number"
    return None
