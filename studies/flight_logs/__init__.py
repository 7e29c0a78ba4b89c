"""Solar power models against flight logs.

* ``verification``: ``verify``: errors of all models, and what looks wrong in the flight
* ``samples``, ``errors``, ``log_view``: models on a log, their errors, the log as rules look at it
* ``anomalies``: losses and gaps by periods; ``synthetic``: logs with known faults
* ``plots``: figures
"""
