"""Where the models end: what a result takes from outside the range of one of them.

Every model of structure, aerodynamics, propulsion, battery, sky and solar power holds within a
range: that of its data, its fit, its publication, or an assumption that says so. The ranges stand
once, with their sources, in ``sizing/data/validity.csv``; those that an airfoil's table, an
aircraft or a mission gives are read there. Nothing is refused for being outside: the result says
so.

* ``ranges``: the catalogue, a quantity beside its range, and what is told of it
* ``checks``: the quantities that are looked at
* ``extrapolations``: what is told of a design, of many, and of cells
"""
