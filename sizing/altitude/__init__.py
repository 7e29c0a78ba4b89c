"""Flight at altitude: how high it is perpetual, and potential energy as storage.

* ``ceiling``: highest altitude of perpetual flight
* ``climb_cycle``: one aircraft with climbs beside its level flight; ``climb_day``: days of many,
  with ``climb_levels``, ``climb_chain``, ``climb_march``, ``climb_run`` and ``climb_repetition``
  behind it
"""
