"""Solar power models against flight logs.

* ``verification``: ``verify``, which puts the others together
* ``forward``: models on a log; ``errors``: how far they are off, and where
* ``left_out``: what says nothing; ``estimates``: what a log tells; ``plots``: figures
"""
