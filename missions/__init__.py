"""Mission layer: where, when and in which air an aircraft flies, and the mission library.

The names of ``dir(missions)`` are what one may use; a name is imported when it is first asked for.
Built on :mod:`solar` only.

* ``load_mission`` reads a mission; ``Mission`` holds place, dates, air, load, wind and flight path
* ``read_flight_log`` reads a log of a real flight
* ``files``: strict YAML with the line of every mistake; ``logs``: flight logs
"""

import lazy_loader

try:
    from solar._version import __version__ as __version__
except ModuleNotFoundError as error:  # such as a script of that name beside the user's own
    import solar

    raise ImportError(
        f"{solar.__file__} hides the package 'solar' of solar-uav-sizing: give that file another "
        "name"
    ) from error

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
