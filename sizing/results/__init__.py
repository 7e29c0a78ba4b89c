"""What :func:`sizing.analyse` and :func:`sizing.size` compute: plain numbers, names and arrays.

* ``analysis``, ``uncertainty``, ``weather``: analyses; ``sizing``, ``weather_sizing``: sizings
* ``result``: what all of them are; how they read and their records are those of the layer above
* ``measures`` of flights; ``margins`` of requirements, ``propulsion``, ``parts``, ``conditions``,
  ``qualities``, ``season``: what results are made of
"""
