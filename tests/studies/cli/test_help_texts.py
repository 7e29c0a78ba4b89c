"""Help texts: commands by what one does with them, an example each, lines that fit."""

import shlex

import click
import pytest
from click.testing import CliRunner

from studies.cli import __main__ as main
from studies.cli.command import COMMANDS, Command

NAMES = list(COMMANDS)


def command(name: str) -> click.Command:
    found = main.cli.get_command(click.Context(main.cli), name)
    return found


def help_text(*names: str, columns: int = 80) -> str:
    # The formatter takes two columns less than the terminal has, at most 78.
    done = CliRunner().invoke(
        main.cli, [*names, "--help"], prog_name="solar-uav", terminal_width=columns - 2
    )
    assert done.exit_code == 0
    return done.output


def test_every_command_stands_under_what_it_is_for():
    text = help_text()
    for name, made in COMMANDS.items():
        _, _, below = text.partition(f"\n{made.task}:\n")
        section, _, _ = below.partition("\n\n")
        assert f"  {name} " in section


@pytest.mark.parametrize("name", NAMES)
def test_the_example_of_a_command_is_one_that_it_takes(name):
    it = command(name)
    assert isinstance(it, Command)
    assert it.examples
    for example in it.examples:
        program, called, *rest = shlex.split(example.partition(" > ")[0])
        assert (program, called) == ("solar-uav", name)
        it.make_context(name, rest, parent=click.Context(main.cli, **main.cli.context_settings))
        assert example in " ".join(help_text(name).replace("\\\n", "").split())


@pytest.mark.parametrize("columns", [60, 80])
def test_lines_of_helps_fit(columns):
    for names in ((), *((name,) for name in NAMES)):
        assert max(map(len, help_text(*names, columns=columns).splitlines())) <= columns


def test_names_to_choose_from_are_told_as_they_are_written():
    text = help_text("size")
    assert "--model [CDM|CAM|VM|FM]" in text
    assert "--objective NAME" in text
    assert "One of max_excess_time, min_wingspan," in " ".join(text.split())


@pytest.mark.parametrize("name", NAMES)
def test_a_page_explains_at_most_18_options_and_names_the_others(name):
    page, shared = help_text(name), help_text()
    explained, _, named = page.partition("More, which solar-uav --help explains")
    assert explained.count("\n  -") <= 18 + 1  # with --help
    for option in (one for one in COMMANDS[name].params if isinstance(one, click.Option)):
        if not option.hidden:
            spelled = option.opts[0]
            assert f" {spelled}" in explained or (spelled in named and f" {spelled}" in shared)
