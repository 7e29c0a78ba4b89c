"""Published numbers beside computed ones.

* ``published``, ``report_reproduction``: flights and the report's table
* ``built_aircraft``: their sizes and masses; ``found_designs``, ``structure_comparison``: from them
* ``clear_sky_comparison``, ``power_curve``, ``altitude_tables``: tables of the documentation
"""
