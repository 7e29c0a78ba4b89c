"""Study layer: sweeps, comparisons, verification, figures and the ``solar-uav`` command.

The names of ``dir(studies)`` are what one may use; a name is imported when it is first asked for.
The topmost layer and the only one that draws, prints or parses a command line. Built on
:mod:`sizing`, :mod:`missions` and :mod:`solar`.

* ``compare``: all solar power models side by side, and what each would have built
* ``verify``: the models against a flight log
* ``perpetual_ceiling``: how high an aircraft flies perpetually
* ``feasibility_map``, ``resized_map``: where and when it does, and which design would
* ``sweep``: trade studies; ``to_table``: these and maps with a row for each cell
* ``plot_cycle``: an analysis as a figure
"""

import lazy_loader

from sizing import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
