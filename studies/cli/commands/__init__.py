"""Options of all commands, in the order in which one uses them: start, design, analyse, verify."""

from studies.cli.commands import start as start  # noqa: I001 - the order of the help text
from studies.cli.commands import design as design
from studies.cli.commands import analyse as analyse
from studies.cli.commands import verify as verify
