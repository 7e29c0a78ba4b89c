"""The architecture page names what there is, and its way of an analysis is the one walked."""

import importlib
import re
import sys

import numpy as np
import pytest
from documented import DOCS, ROOT
from scipy.sparse.csgraph import connected_components

import missions
import sizing

LAYERS = ("solar", "missions", "sizing", "studies")
PAGE = (DOCS / "architecture.md").read_text(encoding="utf-8")
NAMES = sorted(set(re.findall(r"`([a-z_.]+):([A-Za-z_.]+)`", PAGE)))


@pytest.mark.parametrize(("module", "name"), NAMES, ids=lambda text: text)
def test_name_exists(module, name):
    if module == "module":  # how names are written
        return
    found = importlib.import_module(module)
    for part in name.split("."):
        found = getattr(found, part)


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`([a-z_]+/[a-z_/.]+)`", PAGE))))
def test_file_exists(path):
    assert (ROOT / path).exists()


def functions_entered(call):
    """Functions of the project in the order in which they are first entered."""
    entered = {}

    def watch(frame, event, _):
        module = frame.f_globals.get("__name__", "")
        if event == "call" and module.partition(".")[0] in LAYERS:
            entered.setdefault(f"{module}:{frame.f_code.co_qualname}")

    sys.setprofile(watch)
    try:
        call()
    finally:
        sys.setprofile(None)
    return list(entered)


def test_way_of_an_analysis_is_walked_in_this_order():
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    mission = missions.load_mission("rafz-july")

    def asked():
        analysis = sizing.analyse(aircraft, mission)
        assert str(analysis)
        assert analysis.to_dict()

    entered = functions_entered(asked)
    way = PAGE.partition("## The way of an analysis")[2].partition("## The way of a sizing")[0]
    named = [f"{module}:{name}" for module, name in re.findall(r"`([a-z_.]+):([A-Za-z_.]+)`", way)]
    functions = [name for name in named if name.rpartition(":")[2].rpartition(".")[2].islower()]
    # Reading the files is over by then, and VM and FM are not flown.
    left_out = ("missions.files", "missions.library", "sizing.library", "missions.loiter_power")
    walked = [name for name in functions if not name.startswith(left_out)]
    assert len(walked) >= 8
    places = [entered.index(name) for name in walked]
    assert places == sorted(places)


def test_no_files_import_each_other():
    grimp = pytest.importorskip("grimp")
    packages = ("solar", "missions", "sizing", "studies")
    graph = grimp.build_graph(*packages, exclude_type_checking_imports=True)
    # The door of a package is no file of its own.
    names = sorted(m for m in graph.modules if not graph.find_children(m))
    imported = [graph.find_modules_directly_imported_by(name) for name in names]
    imports = np.array([[name in of_module for name in names] for of_module in imported])
    _, circle = connected_components(imports, connection="strong")
    size = np.bincount(circle)[circle]
    assert [name for name, count in zip(names, size, strict=True) if count > 1] == []
