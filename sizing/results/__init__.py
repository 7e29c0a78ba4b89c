"""What :func:`sizing.analyse` and :func:`sizing.size` return, and how results print themselves.

* ``tables``: tables and summaries, rendered as text, Markdown, HTML, CSV or a frame
* ``analysis``: an aircraft on a mission, with ``analysis_summary`` for its text
* ``sizing``: a sized aircraft, with ``sizing_summary`` for its text
* ``propulsion``, ``parts``, ``conditions``, ``requirements``: blocks of both, numbers and words
* ``notes``: what is told of the ranges of the models
* ``records``: numbers of results as JSON writes them
"""
