"""Physics layer: sun, atmosphere, aircraft, propulsion, solar array and battery models.

The lowest of the four layers. It knows nothing of missions, of optimisation or of
reports: its functions take plain numbers, arrays or CasADi expressions with units in
their names and return the same.
"""

from solar._version import __version__

__all__ = ["__version__"]
