"""What :func:`sizing.analyse` and :func:`sizing.size` compute: plain numbers, names and arrays.

* ``analysis``, ``uncertainty``, ``weather``: analyses; ``sizing`` makes a ``sizing_study``
* ``result``: what all of them are; how they read and their records are those of the layer above
* ``design_result``: what results with a design have
"""
