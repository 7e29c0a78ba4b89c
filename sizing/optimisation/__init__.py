"""The best design for a mission, or why there is none.

* ``objectives``, ``energy_constraints``, ``problem``: the nonlinear program as data
* ``solver``, ``search``, ``cells``: solved until the simulator confirms it, for one or many
* ``relaxations``, ``sensitivity``, ``cross_check``, ``coverage``: what is asked of an optimum, or
  where there is none
* ``result``: how a sizing ended
"""
