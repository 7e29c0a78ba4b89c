"""Battery over day and night.

* ``battery``: capacity, efficiencies, limit of the charging power
* ``march``: the battery integrated over time, a batch of designs and scenarios at once
* ``cycle``: metrics of one day repeated; ``endurance``: the longest flight
* ``settling``: days from an empty battery, until the repeated day settles or as many as one likes
* ``power_balance``: exact integrals that both use
"""
