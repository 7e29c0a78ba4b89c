"""Solar layer: from the position of the sun to the electric power of the solar modules.

The lowest of the four layers. It knows nothing of missions, of aircraft sizing or of
reports.
"""

from solar._version import __version__

__all__ = ["__version__"]
