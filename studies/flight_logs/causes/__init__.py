"""Causes that compete for what a flight log shows, before anything is blamed.

* ``forward``: modelled power of samples if something about the log were different
* ``fit``: the most likely errors of log, model and sky under one hypothesis, and its score
* ``losses``: periods and modules with missing power, searched for
* ``hypotheses``: the table of all causes; ``diagnosis``: which wins, and what fits as well; samples
  with limited charging, which say nothing
"""
