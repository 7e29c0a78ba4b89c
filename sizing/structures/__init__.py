"""Structural mass of the airframe.

* ``models``: the choice of models, by mass regression or by a spar sized for its strength
* ``rib_wing``: rib wing with a box spar of carbon fibre, part by part; ``stiffening``: against
  flutter, divergence and twist, foam in deep webs and wires to the wing
* ``loads``: load factors and bending moments; ``build``: build quality, a factor on all models
* ``assessment``: sizing criteria, deflections and V-n diagram of a wing
"""
