"""Clock, heading and unit of a log from its power, before anything is blamed on the aircraft.

* ``offsets``: ``align``: the estimates, and what counts as an error of the log
* ``robust_fit``: level, clock and heading by robust least squares, with their covariance
* ``shifted_power``: modelled power of samples at another clock and heading
"""
