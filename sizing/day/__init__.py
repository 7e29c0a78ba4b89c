"""A day: what it does to battery and height. One march, and what is flown by it.

* ``light``, ``module_power``: specific power of the modules
* ``load``: what the aircraft draws; ``heights``, ``chain_at_heights``: both along heights
* ``battery``: batteries of a batch, the charge limit; ``balance``: exact integrals of an interval
* ``march``: the charge along any time axis, nights as one step; ``metrics``: the excess time

* ``cycle``: a day that repeats itself, a flight to a landing; ``flight``, ``launch``: from a launch
  until the battery is empty, and the best launch
* ``record``, ``record_days``, ``carried``: days of a weather record, the charge carried over;
  ``replay``: a flight by the clock
"""
