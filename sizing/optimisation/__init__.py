"""The best design for a mission, or why there is none.

* ``objectives``, ``energy_constraints``, ``problem``: the nonlinear program as data
* ``solver``, ``search``, ``cells``: solved until the simulator confirms it, for one or many
* ``infeasibility``, ``relaxations``: why there is no design, and what would change that
* ``sensitivity``, ``cross_check``, ``coverage``: how an optimum changes, whether a search finds a
  better one, and the widest range that one design covers
* ``result``: how a sizing ended
"""
