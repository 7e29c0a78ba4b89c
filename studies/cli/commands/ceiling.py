"""The command ``solar-uav ceiling``."""

from __future__ import annotations

from dataclasses import dataclass

from studies.cli.command import Command, RealRange, option
from studies.cli.options import CaseOptions, case_options, figure_options, plot_option, table_option
from studies.output.figures.options import FigureOptions

_HIGHEST_M, _LEAST_STEP_M = 32000.0, 10.0


@dataclass(frozen=True)
class Ceiling:
    """Find how high AIRCRAFT (name, file or folder) flies perpetually; exit code 1 if nowhere."""

    case: CaseOptions = case_options()
    highest_m: float | None = option(
        "--highest",
        type=RealRange(-500.0, _HIGHEST_M, unit="metres"),
        metavar="METRES",
        help="End of the search, which starts at the mission's altitude and goes down from there "
        "where nothing above is feasible; by default 20000, for missions above 15000 m 32000.",
    )
    step_m: float = option(
        "--step",
        type=RealRange(_LEAST_STEP_M, 10000.0, unit="metres"),
        default=250.0,
        show_default=True,
        metavar="METRES",
        help="Spacing of the altitudes that are tried.",
    )
    table_file: str | None = table_option("the altitudes")
    plot_file: str | None = plot_option("Draw them")
    figure: FigureOptions = figure_options()


ceiling = Command(
    "ceiling", Ceiling, "ceiling:ceiling", "solar-uav ceiling atlantiksolar-as2 --plot ceiling.png"
)
