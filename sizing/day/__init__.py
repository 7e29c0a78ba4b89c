"""A day of flight: light, load and battery along any time axis, and one march through it.

* ``light``, ``module_power``: specific power of the modules, at all levels of a mission
* ``load``: electric load; ``heights``, ``chain_at_heights``: light and load along heights
* ``battery``: batteries of a batch, the charge limit; ``balance``: exact integrals of an interval
* ``march``: the charge along a time axis, nights as one step; ``metrics``: the excess time

* ``cycle``: a day that repeats itself, a flight to a landing; ``flight``: from a launch until the
  battery is empty, and the best launch
* ``record``: days of a weather record, the charge carried over; ``record_conditions``: their light,
  load and batteries; ``replay``: a flight by the clock
"""
