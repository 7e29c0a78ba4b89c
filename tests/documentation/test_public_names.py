"""What ``dir()`` of the four packages offers is there, documented, and light to import."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import subprocess
import sys

import pytest

PACKAGES = ("solar", "missions", "sizing", "studies")


def public_names() -> list[tuple[str, str]]:
    return [(p, name) for p in PACKAGES for name in dir(importlib.import_module(p))]


@pytest.mark.parametrize(("package", "name"), public_names())
def test_public_name_is_there_and_documented(package: str, name: str) -> None:
    found = getattr(importlib.import_module(package), name)
    if inspect.isclass(found) or inspect.isfunction(found):
        assert inspect.getdoc(found)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_public_name_is_hidden_by_a_module(package: str) -> None:
    # Importing a submodule sets an attribute of its package, whatever was there before.
    module = importlib.import_module(package)
    modules = {one.name for one in pkgutil.iter_modules(module.__path__)}
    assert not modules & set(dir(module))


def test_importing_the_packages_imports_nothing_heavy() -> None:
    code = f"import {', '.join(PACKAGES)}, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "casadi", "pandas", "xarray", "matplotlib"} & set(done.stdout.split())
