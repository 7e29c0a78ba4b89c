"""Published numbers beside computed ones.

* ``published``, ``report_reproduction``: all numbers, and the report's table
* ``flights``: published flights, and what may explain the differences
* ``built_aircraft``: their sizes and masses; ``found_designs``, ``structure_comparison``: from them
* ``clear_sky_comparison``, ``power_curve``, ``altitude_tables``: tables of the documentation
"""
