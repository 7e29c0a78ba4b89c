"""Commands of the documentation, run in the order of the page: what tests and the replay share."""

import contextlib
import os
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from documented import PAGES, Command, blocks, replaced

# Far above what a command takes, so that a busy machine does not end it.
TIMEOUT_S = 300
# As it is installed.
SOLAR_UAV = [str(Path(sys.executable).with_name("solar-uav"))]
Streams = tuple[int, str, str]


def blocks_that(holds, pages=PAGES):
    """Blocks of the pages for which something holds."""
    return [block for page in pages for block in blocks(page) if holds(block)]


def is_run(block):
    """Whether the block has commands that are run."""
    return block.not_run is None and bool(block.commands())


def in_subprocess(words, folder=None, variables=None):
    """Exit code, standard output and standard error of a program."""
    done = subprocess.run(
        words,
        cwd=folder,
        env=dict(os.environ, MPLBACKEND="Agg", **(variables or {})),
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def make_wrong_aircraft(folder):
    """The file of ``solar-uav init`` with two mistakes."""
    code, _, err = in_subprocess([*SOLAR_UAV, "init", "bad"], folder)
    assert code == 0, err
    path = folder / "bad.yaml"
    text = path.read_text(encoding="utf-8")
    for old, new in (
        ("wingspan_m: 7.6 ", "wingspann_m: 7.6 "),
        ("discharge_efficiency: 0.97", "discharge_efficiency: 1.2"),
    ):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def made(name, folder):
    """File that commands need, made once in the folder by the Python of a page."""
    path = folder / name
    if path.exists():
        return path
    if name == "bad.yaml":
        make_wrong_aircraft(folder)
        return path
    (block,) = blocks_that(lambda block: name in block.makes)
    script = folder / "make.py"
    script.write_text(block.text, encoding="utf-8")
    with contextlib.chdir(folder):
        runpy.run_path(str(script))
    return path


class Played(NamedTuple):
    """A command that was run, and what it printed."""

    command: Command
    code: int
    out: str
    err: str


def played(block, call, made_in):
    """Run the commands of a block in the current folder, one after the other.

    The call takes the words behind ``solar-uav`` and variables of the environment.
    """
    for name in block.needs:
        if not Path(name).exists():
            shutil.copy(made(name, made_in), name)
    for command in block.commands():
        variables, words, target = command.words()
        if words[0] != "solar-uav":
            done = in_subprocess([sys.executable, *words[1:]], variables=variables)
        else:
            coarser = {o: value for o, value in block.tested_with.items() if o in words}
            done = call(replaced(words, coarser)[1:], {"COLUMNS": "80", **variables})
        if target is not None:
            Path(target).write_text(done[1], encoding="utf-8")
        yield Played(command, *done)
