"""Ranges of the models, and the extrapolated quantities of a result.

Every model of structure, aerodynamics, propulsion, battery, sky and solar power holds within a
range: of its data, its fit, its publication, or by an explicit assumption. ``validity.csv`` in
``sizing/data`` has the ranges with their sources; an airfoil's table, an aircraft or a mission give
some themselves. Results outside a range are not refused, but noted.

* ``ranges``: catalogue of ranges, check of a quantity, and the note on an extrapolation
* ``checks``: checks of a design and its flight
* ``extrapolations``: extrapolated quantities of a design, of many results, and of cells
"""
