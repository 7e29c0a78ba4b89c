"""What tests of the command line share: its outcome, and files to give it."""

import json
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
BIRD, FIELD = ((HERE / name).read_text("utf-8") for name in ("bird.yaml", "field.yaml"))


class Outcome(NamedTuple):
    code: int
    out: str
    err: str

    def good(self):
        """The outcome itself, of a command that had nothing to say of mistakes."""
        assert (self.code, self.err) == (0, "")
        return self

    def json(self):
        """Standard output as strict JSON: NaN and Infinity are refused."""

        def refuse(constant):
            raise AssertionError(f"{constant} is not JSON")

        return json.loads(self.out, parse_constant=refuse)


def edited(text, old, new):
    assert text.count(old) == 1, old
    return text.replace(old, new)


def files(folder):
    return {path.name for path in folder.iterdir()}
