"""The best design for a mission, or why there is none.

* ``variables``, ``transcription``, ``objectives``, ``own_terms``: the nonlinear program as data
* ``task``, ``start``, ``corrections``, ``solve``, ``search``: solved until the simulator agrees
* ``size``: an optimum, or what stands in the way of any
* ``days``, ``climbing``: intervals of a day, and flight along the heights of a program
* ``schedule``, ``climbing_flights``: the best heights of a design that is given
* ``reasons``, ``relaxations``: what is missed where there is no design, and what would change that
* ``sensitivity``: how an optimum changes
* ``result``: how a sizing ended
"""
