"""A day: what it does to battery and height.

* ``light``: specific power of the modules; ``load``: what the aircraft draws
* ``battery``: batteries of a batch; ``march``: their charge along any time axis, exact in a step
* ``cycle``: a day that repeats itself; ``flight``: from a launch to an empty battery
* ``record``: days of a weather record, charge carried over; ``replay``: a flight by the clock
"""
