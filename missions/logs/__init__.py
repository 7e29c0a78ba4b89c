"""Logs of real flights.

* ``csv``: ``read_flight_log``, and text tables; ``delimited``: how such a table is written
* ``columns``: which column is what; ``units``, ``clock``: what its values mean
* ``autopilots``: PX4 ULog and ArduPilot DataFlash
* ``table``: the log, and the checks of what it holds
"""
