"""Structural mass of the airframe.

* ``models``: the choice of models, by mass regression or by a spar sized for its strength
* ``rib_wing``: rib wing with a box spar of carbon fibre, part by part; ``rib_wing_keys``: its keys,
  with foam in deep webs and wires to the wing; ``loads``: load factors and bending moments
* ``build``: build quality of a team, a factor on all models
* ``torsion``: stiffness against flutter, divergence and twist; ``assessment``: sizing criteria,
  deflections and V-n diagram of a wing
"""
