"""What ``solar-uav uncertainty`` does."""

from __future__ import annotations

from sizing.results.uncertainty import analyse_uncertainty
from studies.cli.commands.analyse import Uncertainty
from studies.cli.files import load_flyable, uncertain_inputs_of
from studies.cli.outputs import deliver, figure_of, table_of
from studies.uncertainty import plot_uncertainty


def uncertainty(options: Uncertainty) -> None:
    """Draw uncertain inputs, and tell what becomes of the flight."""
    case = load_flyable(options)
    with uncertain_inputs_of(case):
        result = analyse_uncertainty(
            **case.arguments,
            samples=options.samples,
            seed=options.seed,
            model_error=not options.no_model_error,
        )
    files = {
        options.table_file: table_of(result.to_frame, "draws"),
        options.plot_file: figure_of(lambda: plot_uncertainty(result, figure=options.figure)),
    }
    deliver(case, result, files)
