"""What README and documentation print is what happens: commands, output, Python."""

import re
import runpy
import sys

import click
import pytest
from documented import (
    PAGES,
    ROOT,
    VARIES,
    blocks,
    disagreement,
    inline_commands,
    inline_options,
    not_printed,
)
from played import blocks_that, in_subprocess, is_run, played


def pages_with(holds):
    """Pages that have such blocks, as parameters of a test."""
    found = ((page, blocks_that(holds, [page])) for page in PAGES)
    slow = {page: [pytest.mark.slow] for page, some in found if any(b.slow for b in some)}
    pages = (page for page in PAGES if blocks_that(holds, [page]))
    return [pytest.param(page, id=page.stem, marks=slow.get(page, ())) for page in pages]


def is_python(block):
    """Whether the block is Python that is run for its own sake, not for the file it makes."""
    return block.not_run is None and block.language == "python" and not block.makes


@pytest.fixture(scope="session")
def made_in(tmp_path_factory):
    """Folder of the files that commands need, each made once by the Python of a page."""
    return tmp_path_factory.mktemp("made")


def mistakes(block, done):
    """What is wrong with a command of a page and what it printed."""
    at = f"{block}: {done.command.text.strip()}"
    both = done.out + done.err
    wrong = []
    if done.code != block.exit_code:
        wrong.append(f"{at}\n  exit code {done.code}, not {block.exit_code}: {done.err[-400:]}")
    if "Traceback" in both:
        wrong.append(f"{at}\n  {both[-400:]}")
    if "cells failed" in done.err or "points failed" in done.err:
        wrong.append(f"{at}\n  {done.err[-400:]}")
    if done.command.claimed is not None:
        found = [disagreement(done.command.claimed, text) for text in (done.out, both)]
        if None not in found:
            wrong.append(f"{at}\n  {found[0]}")
    return wrong


@pytest.mark.slow
@pytest.mark.parametrize("page", pages_with(is_run))
def test_commands_of_the_page_print_what_it_says(page, run, made_in, tmp_path, monkeypatch):
    (tmp_path / "docs" / "images").mkdir(parents=True)

    def call(words, variables):
        with monkeypatch.context() as patch:
            for name, value in variables.items():
                patch.setenv(name, value)
            return run(*words)

    monkeypatch.chdir(tmp_path)
    wrong = []
    for block in blocks_that(is_run, [page]):
        done = list(played(block, call, made_in))
        wrong += [mistake for one in done for mistake in mistakes(block, one)]
        printed = "".join(one.out + one.err for one in done)
        wrong += [f"{block}: not printed: {text}" for text in not_printed(block, printed)]
    assert not wrong, "\n".join(["", *wrong])


@pytest.mark.parametrize("block", blocks_that(lambda block: block.not_run is not None), ids=str)
def test_block_that_is_not_run_says_why_and_names_what_exists(block):
    assert block.not_run, f"{block}: no reason"
    for command in block.commands():
        assert not unknown_options(command.text), f"{block}: {command.text}"


def test_every_block_is_run_or_says_why_not():
    for block in blocks_that(lambda block: block.not_run is None):
        if block.language in ("sh", "text"):
            before = [other for other in blocks(block.page) if other.output == block.text]
            assert block.commands() or before, f"{block} is neither commands nor their output"
        for command in block.commands():
            _, words, _ = command.words()
            assert words[0] == "solar-uav" or words[:2] == ["python", "-m"], f"{block}: {words}"


@pytest.mark.slow
@pytest.mark.usefixtures("registries")
@pytest.mark.parametrize("page", pages_with(is_python))
def test_python_of_the_page_runs(page, tmp_path, monkeypatch):
    """Each block in a file of its own; those that start workers in a process of their own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = []
    for number, block in enumerate(blocks_that(is_python, [page])):
        path = tmp_path / f"block{number}.py"
        # Lines count as on the page, so that a traceback names the place.
        path.write_text("\n" * block.line + block.text, encoding="utf-8")
        names.append(path.name)
    alone = [name for name in names if "__main__" in (tmp_path / name).read_text("utf-8")]
    for name in names:
        if name in alone:
            code, _, err = in_subprocess([sys.executable, name], tmp_path)
            assert code == 0, err
        else:
            runpy.run_path(name)


def test_commands_stand_in_blocks_that_are_run():
    for block in blocks_that(lambda block: block.language not in ("sh", "text", "python")):
        assert not re.search(r"^(\$ )?(solar-uav|python) ", block.text, re.M), f"{block}"


def test_claims_leave_out_what_varies_from_run_to_run():
    for block in blocks_that(is_run):
        for claimed in (*block.printed, *(command.claimed or "" for command in block.commands())):
            assert VARIES.search(claimed) is None, f"{block}: put ... for {claimed}"


def command_tree():
    from studies.cli.__main__ import cli

    context = click.Context(cli)
    found = {name: cli.get_command(context, name) for name in cli.list_commands(context)}
    return {name: command for name, command in found.items() if command is not None}


def options_of(command):
    return {name for p in command.params for name in (*p.opts, *p.secondary_opts)} | {"--help"}


def unknown_options(text):
    """Options in a call that its command does not have, and the command if there is none."""
    words = text.replace("[", " ").replace("]", " ").split()
    if not words or words[0] != "solar-uav" or len(words) == 1:
        return set()
    if words[1].startswith("-") or words[1] == "COMMAND":
        return set()
    command = command_tree().get(words[1])
    if command is None:
        return {words[1]}
    named = {word.partition("=")[0].rstrip(".") for word in words[2:] if word.startswith("-")}
    return {name for name in named if name.startswith("--")} - options_of(command)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_calls_within_the_text_name_commands_and_options_that_exist(page):
    for text in inline_commands(page):
        assert not unknown_options(text), f"{page.name}: `{text}`"


# Options of other programs that the pages name.
FOREIGN = {
    "upgrade.md": {  # of versions before
        *("--as-logged", "--explain", "--season", "--static", "--batteries", "--best-climb"),
        "--days",
    },
    "CONTRIBUTING.md": {
        *("--airfoil", "--out", "--check", "--markdown", "--count", "--dist", "--keep", "--slow"),
        *("--only", "--against", "--rows"),
    },
    "performance.md": {"--markdown", "--json", "--only"},
    "maps.md": {"--long"},
    "validation.md": {"--count", "--rows", "--cases"},
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_options_within_the_text_exist(page):
    known = set().union(*(options_of(command) for command in command_tree().values()))
    named = inline_options(page) - FOREIGN.get(page.name, set())
    assert named <= known | {"--version"}, f"{page.name}: {sorted(named - known)}"


def rows_of_table(text, heading):
    """Cells of the table whose first row begins with a heading."""
    table = re.search(rf"^\| {heading} \|.*\n\|[-:|\s]+\n((?:\|.*\n)+)", text, re.M)
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in table[1].splitlines()]


def test_numbers_of_the_readme_are_those_of_the_validation():
    """``docs/validation.md`` is compared with what is computed by another test."""
    text = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    known = [(float(row[3]), float(row[4])) for row in rows_of_table(text, "quantity")]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for name, published, computed in rows_of_table(readme, "quantity"):
        value, digits = computed.split()[0], len(computed.split()[0].partition(".")[2])
        found = [c for p, c in known if p == float(published.split()[0])]
        assert float(value) in [round(c, digits) for c in found], name


@pytest.mark.parametrize(
    ("claimed", "actual"),
    [
        ("mass 4.14 kg", "mass 4.16 kg"),
        ("mass 4.14 kg", "mass 4.140 kg"),
        ("mass 4.14 kg", "mass │ 4.14 kg"),
        ("┌───┐", "┏━━━┓"),
        ("12 cells", "13 cells"),
        ("a", "a b"),
        ("b", "a b"),
        ("...\nb 2\nd", "a 1\nb 2\nc 3"),
        ("a\n...\nc\nb", "a b b c"),
        ("a b", "a"),
    ],
)
def test_claims_that_do_not_agree(claimed, actual):
    assert disagreement(claimed, actual) is not None
