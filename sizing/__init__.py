"""Sizing layer: aircraft, their day and night energy balance, and their optimisation.

``dir(sizing)`` lists the public names; a name is imported at its first use.
Built on :mod:`missions` and :mod:`solar`.

* ``load_aircraft`` reads an aircraft, ``analyse`` says how long it flies, ``size`` finds the best
* ``performance_of_designs``, ``size_cells``: the same for many at once
* ``structures``, ``aerodynamics``, ``propulsion``, ``battery``, ``day``, ``program``: the physics
  and the mathematics behind them, one sub-package each
"""

import lazy_loader

from missions import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
