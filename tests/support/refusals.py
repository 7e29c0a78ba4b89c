"""Tables of what is refused, and in which words.

``[BEGIN]`` heads rows ``REST => MESSAGE`` of what begins with it; ``NAME := TEXT`` gives a piece of
text a name, which rows write as ``$NAME``; ``$HERE`` is the folder that tests run in.
"""

from pathlib import Path
from string import Template

import pytest
import yaml

from missions.files.errors import InputError


def refusals(path):
    """Return the rows of a table: what it begins with, the rest, the message."""
    names, begin, rows = {"HERE": str(Path.cwd())}, "", []
    for line in path.read_text(encoding="utf-8").splitlines():
        left, sign, right = Template(line).substitute(names).partition(" => ")
        if sign:
            rows.append((begin, left, right))
        elif " := " in left:
            name, _, text = left.partition(" := ")
            names[name] = text
        elif left.startswith("["):
            begin = left[1:-1]
    return rows


def refusal_of(load, name, changes):
    """Return the words in which changes of a shipped file are refused."""
    with pytest.raises(InputError) as refused:
        load(name, yaml.safe_load(changes))
    return " | ".join(f"{one.key}: {one.message}" for one in refused.value.problems)
