"""Solar layer: from the position of the sun to the electric power of the solar modules.

The names of ``dir(solar)`` are what one may use; a name is imported when it is first asked for.
The lowest of the four layers: it knows nothing of missions, of aircraft sizing or of reports.

* ``declination``, ``sun_times``, ``sun_vector_ned``: where the sun is
* ``clear_sky``: direct and diffuse light
* ``conceptual_design_model`` (CDM), ``conceptual_analysis_model`` (CAM), ``verification_model``
  (VM), ``full_model`` (FM): power of the modules, and ``correction`` of their systematic error
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
