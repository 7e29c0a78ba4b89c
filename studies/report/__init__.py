"""Reports: one page about a design, its mission and what to believe of it.

* ``document``: the page, ``make_report``, with its verdict; ``subject``: what it is about
* ``sections``, and the ``blocks`` that they consist of
* ``geometry``, ``three_view``: the drawing
* ``pdf``: the page as PDF
"""
