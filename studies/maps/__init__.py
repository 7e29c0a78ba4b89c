"""Maps over latitude and season: of a fixed aircraft, or sized anew in every cell.

* ``feasibility``: of a fixed aircraft; ``season``: days of perpetual flight at one latitude
"""
