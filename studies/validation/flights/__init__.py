"""Published flights: what is known of them, what is computed, and what may explain the difference.

* ``published_flights``: facts and numbers with their sources
* ``inputs``, ``single_inputs``: how well the inputs are known, and what each would have to be
* ``season``: what changes the season of perpetual flight
"""
