"""Study layer: sweeps, comparisons, reports, figures and the ``solar-uav`` command.

The topmost layer and the only one that draws, prints or parses a command line. Built
on :mod:`sizing`, :mod:`missions` and :mod:`solar`.
"""
