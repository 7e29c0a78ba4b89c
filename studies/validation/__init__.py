"""Published numbers beside computed ones.

* ``published``, ``report_reproduction``: all numbers, and the report's table
* ``flights``: published flights, and what may explain the differences
* ``built_aircraft``: their sizes and masses

Comparisons that no command prints are in the project's folder ``benchmarks/validation``.
"""
