"""Flight at altitude: how high it is perpetual, and potential energy as storage.

* ``ceiling``: highest altitude of perpetual flight
* ``climb_cycle``: day with climbs and glides; ``climb_levels`` and ``climb_march`` behind it
"""
