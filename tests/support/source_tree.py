"""Parts of the source tree that are not installed, for tests that run on what is installed."""

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def make_benchmarks_importable():
    """Make the folder ``benchmarks`` a package without its neighbours on the import path."""
    if importlib.util.find_spec("benchmarks") is not None:
        return
    folder = ROOT / "benchmarks"
    spec = importlib.util.spec_from_file_location(
        "benchmarks", folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules["benchmarks"] = package
    spec.loader.exec_module(package)
