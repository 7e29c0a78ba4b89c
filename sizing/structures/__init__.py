"""Structural mass of the airframe.

* ``models``: the choice of models, by mass regression or by a spar sized for its strength
* ``rib_wing``: rib wing with a box spar of carbon fibre, part by part; ``loads``: what sizes it
* ``torsion``: stiffness against flutter, divergence and twist; ``assessment``: what sized a wing
"""
