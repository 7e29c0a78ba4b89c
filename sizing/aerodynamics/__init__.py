"""Drag of the aircraft and power of level flight.

* ``parabolic``: drag polar of a whole aircraft, and power of level flight
* ``wing_polar``: wing with an airfoil; ``airfoil_polar`` and ``polar_table`` behind it
"""
