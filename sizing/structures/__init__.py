"""Structural mass of the airframe.

* ``models``: the choice of models, by mass regression or by a spar sized for its strength
* ``rib_wing``: rib wing with a box spar of carbon fibre, part by part; ``rib_wing_keys``: its keys,
  with those of foam in deep webs and of wires to the wing; ``loads``: what sizes it
* ``build``: how well a team builds, a factor on all of them
* ``torsion``: stiffness against flutter, divergence and twist; ``assessment``: what sized a wing
"""
