"""Structural mass of the airframe.

* ``models``: the choice of models, by mass regression or by a spar sized for its strength
* ``rib_wing``: rib wing with a box spar of carbon fibre, part by part; ``loads``: what sizes it
* ``rib_wing_keys``: its keys; ``web_core``, ``bracing``: foam in deep webs, wires to the wing
* ``agreement``: the other model beside that of a file
* ``torsion``: stiffness against flutter, divergence and twist; ``assessment``: what sized a wing
"""
