"""Maps over latitude and season: of a fixed aircraft, or sized anew in every cell.

* ``study``: both kinds, with what computes their cells
* ``results``, ``plots``: what the terminal, JSON and figures show
* ``season``: days of perpetual flight at one latitude
"""
