"""Published numbers beside computed ones.

* ``published``, ``report_reproduction``: flights and the report's table
* ``found_designs``, ``known_structures``, ``structure_comparison``: built aircraft
* ``clear_sky_comparison``, ``power_curve``, ``altitude_tables``: tables of the documentation
"""
