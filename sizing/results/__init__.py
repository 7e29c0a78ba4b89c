"""What :func:`sizing.analyse` and :func:`sizing.size` return, how it reads, and its record.

* ``analysis``, ``sizing``, ``sizing_study``: results and how they are computed, plain numbers, with
  ``propulsion``, ``parts``, ``conditions``, ``requirements`` and ``season``
* ``quantities``: the table of quantities: key, path, words, unit, form, importance
* ``serialise``: any result as data for JSON
* ``render``: a result at a level as blocks, with ``sentences`` and ``tables``, which knows text,
  Markdown, HTML and LaTeX
"""
