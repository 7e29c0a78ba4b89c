"""Flight at altitude: how high it is perpetual, and potential energy as storage.

* ``ceiling``: highest altitude of perpetual flight
* ``climb``: one aircraft with climbs beside its level flight; ``climb_levels``, ``climb_chain``:
  what it does at all heights
"""
