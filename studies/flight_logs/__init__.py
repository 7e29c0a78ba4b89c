"""Solar power models against flight logs.

* ``verification``: ``verify``, which puts the others together
* ``forward``, ``samples``: models on a log; ``errors``, ``residuals``: how far they are off, where
* ``left_out``: what says nothing; ``fit``, ``level_power``, ``estimates``: what a log tells
* ``trackers``: MPPTs one by one; ``synthetic``: logs with known faults; ``plots``: figures
"""
