"""Reports: one page about a design, its mission and what to believe of it.

* ``document``: the page, ``make_report``; ``subject``: what it is about; ``blocks``: its parts
* ``verdict`` in one sentence with its numbers, ``sections``
* ``geometry``, ``three_view``: the drawing
* ``pdf``: the page as PDF
"""
