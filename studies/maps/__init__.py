"""Maps over latitude and season: of a fixed aircraft, or sized anew in every cell.

* ``feasibility``: of a fixed aircraft; ``resized``: the best design of each cell
* ``results``, ``plots``: what the terminal, JSON and figures show
* ``season``: days of perpetual flight at one latitude
"""
