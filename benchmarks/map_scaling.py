"""The feasibility map against a loop in C, its cost against its size, and its memory."""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measuring import best_time_s, row
from missions.library import load_mission
from missions.mission import Scenarios
from sizing.energy.battery import Store
from sizing.energy.cycle import ENDS
from sizing.library import load_aircraft
from sizing.mass_budget import design_of
from sizing.sunlight import SolarModel, day_axis_h
from solar.clearsky import coefficients, pressure_ratio
from solar.sun import declination, hour_angle, sun_arc
from studies.maps.feasibility import map_block

_AIRCRAFT, _MISSION = "atlantiksolar-as2", "rafz-july"
_LATITUDES, _DAYS = np.linspace(-90.0, 90.0, 181), np.arange(1, 366)
_SOURCE = Path(__file__).with_name("map_bound.c")
# Order of the metrics in the C source.
_METRICS = (
    "excess_time",
    "minimum_state_of_charge",
    "charge_margin",
    "equal_power_morning",
    "equal_power_evening",
    "full_charge",
    "solar_energy",
    "load_energy",
    "status",
)


def _row(
    work: str, ours_s: float, peer: str | None = None, peer_s: float | None = None
) -> dict[str, Any]:
    return row("map", work, ours_s, peer, peer_s)


def _map(latitudes: Any, days: Any) -> dict[str, Any]:
    aircraft, mission = load_aircraft(_AIRCRAFT), load_mission(_MISSION)
    return map_block(aircraft, mission, latitudes, days, SolarModel())


def full_map() -> list[dict[str, Any]]:
    """The full map against the C loop."""
    ours = best_time_s(lambda: _map(_LATITUDES, _DAYS), 3)
    work = f"{len(_LATITUDES)} latitudes x {len(_DAYS)} days, all metrics; processor time"
    with tempfile.TemporaryDirectory() as folder:
        library = _compiled(Path(folder))
        if library is None:
            return [_row(work, ours)]
        bound = _Bound(library)
        bound.check(_map(_LATITUDES, _DAYS))
        peer = f"C loop, {bound.compiler} -O3, one thread"
        return [_row(work, ours, peer, best_time_s(bound.run, 3))]


def map_endurance() -> list[dict[str, Any]]:
    """A ninth of the full map with the longest flight of every cell."""
    aircraft, mission = load_aircraft(_AIRCRAFT), load_mission(_MISSION)
    begun = time.process_time()
    part = map_block(aircraft, mission, _LATITUDES[::3], _DAYS[::3], SolarModel(), True)
    used = time.process_time() - begun
    ends = int(np.isfinite(part["endurance"]).sum())
    text = f"{part['status'].size} cells with endurance, finite in {ends}; processor time"
    return [_row(text, used)]


def _compiled(folder: Path) -> Path | None:
    compiler = shutil.which("gcc")
    if compiler is None:
        print("no gcc: the map is not measured against C", file=sys.stderr)
        return None
    library = folder / "map_bound.so"
    command = [compiler, "-O3", "-shared", "-fPIC", str(_SOURCE), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    return library


_DOUBLES = ctypes.POINTER(ctypes.c_double)


class _Craft(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_int) for name in ("nodes", "half", "pieces", "clock_nodes")),
        *(
            (name, _DOUBLES)
            for name in (
                "time_h",
                "cos_hour",
                "curve_begin",
                "curve_end",
                "cubic",
                "clock_soc",
                "clock_h",
            )
        ),
        *(
            (name, ctypes.c_double)
            for name in (
                "pressure",
                "common",
                "camber",
                "diffuse",
                "first_angle",
                "last_angle",
                "area_m2",
                "load_w",
                "battery_energy_wh",
                "eta_charge",
                "eta_discharge",
                "constant_up_to",
                "constant_rate_per_h",
            )
        ),
    ]


class _Bound:
    """The C loop with the data of the map."""

    compiler = "gcc"

    def __init__(self, library: Path) -> None:
        self._function = ctypes.CDLL(str(library)).map_cells
        self._function.restype = None
        self._kept: list[Any] = []
        self._craft = self._described()
        latitude = np.repeat(_LATITUDES, len(_DAYS))
        day = np.tile(_DAYS, len(_LATITUDES))
        noon = Scenarios(latitude, day).noon_day
        skies = (*sun_arc(latitude, declination(noon)), *coefficients(noon, latitude))
        self._skies = np.ascontiguousarray(np.stack(skies, axis=-1))
        self._work = np.empty(4 * self._craft.nodes)
        self._result = np.empty((len(latitude), len(_METRICS)))

    def _pointer(self, values: Any) -> Any:
        array = np.ascontiguousarray(values, float)
        self._kept.append(array)
        return array.ctypes.data_as(_DOUBLES)

    def _described(self) -> _Craft:
        aircraft, mission = load_aircraft(_AIRCRAFT), load_mission(_MISSION)
        modules, store = aircraft.modules, Store.of(aircraft.battery)
        design, clock = design_of(aircraft, mission), store.clock
        assert clock is not None  # of this aircraft
        curve = modules._incidence_curve
        pieces, time_h = curve._pieces, day_axis_h()
        temperature = modules.temperature_efficiency(mission.module_temperature_c())
        half = (len(time_h) + 1) // 2
        return _Craft(
            nodes=len(time_h),
            half=half,
            pieces=len(pieces.begin),
            clock_nodes=len(clock.hours),
            time_h=self._pointer(time_h),
            cos_hour=self._pointer(np.cos(hour_angle(time_h[:half]))),
            curve_begin=self._pointer(pieces.begin),
            curve_end=self._pointer(pieces.end),
            cubic=self._pointer(pieces.cubic),
            clock_soc=self._pointer(clock.state_of_charge),
            clock_h=self._pointer(clock.hours),
            pressure=float(pressure_ratio(mission.altitude_m)),
            common=float(
                modules.efficiency_stc * temperature * modules.mppt_efficiency * mission.clearness
            ),
            camber=modules.camber_efficiency,
            diffuse=modules.diffuse_efficiency,
            first_angle=curve.x[0],
            last_angle=curve.x[-1],
            area_m2=modules.area_m2,
            load_w=float(design.nominal_load_w(mission)),
            battery_energy_wh=aircraft.battery.battery_energy_wh,
            eta_charge=store.charge_efficiency,
            eta_discharge=store.discharge_efficiency,
            constant_up_to=clock.constant_up_to,
            constant_rate_per_h=clock.constant_rate_per_h,
        )

    def run(self) -> Any:
        """Compute the whole map."""
        self._function(
            ctypes.byref(self._craft),
            ctypes.c_int(len(self._skies)),
            self._skies.ctypes.data_as(_DOUBLES),
            self._work.ctypes.data_as(_DOUBLES),
            self._result.ctypes.data_as(_DOUBLES),
        )
        return self._result

    def check(self, ours: dict[str, Any]) -> None:
        """Compare with our map: a bound that computes something else is none."""
        metrics = self.run()
        for number, name in enumerate(_METRICS):
            theirs = metrics[:, number].reshape(ours[name].shape)
            # The repeated day is settled to 1e-11 of the battery on both sides.
            np.testing.assert_allclose(theirs, ours[name], rtol=1e-8, atol=1e-8, err_msg=name)
        assert set(np.unique(ours["status"])) == {s.value for s in ENDS}


def two_processes() -> list[dict[str, Any]]:
    """The full map in two processes that are already running."""
    parts = np.array_split(_LATITUDES, 8)
    with ProcessPoolExecutor(2) as pool:
        times = []
        for _ in range(4):
            begun = time.perf_counter()
            list(pool.map(_map, parts, [_DAYS] * len(parts)))
            times.append(time.perf_counter() - begun)
    return [_row("the full map in two warm processes; wall time", min(times[1:]))]


def map_memory() -> list[dict[str, Any]]:
    """Most memory of a process that computes the full map, Python and libraries included."""
    code = (
        "import json, resource, sys, time\n"
        "from benchmarks import map_scaling as m\n"
        "begun = time.process_time()\n"
        "m._map(m._LATITUDES, m._DAYS)\n"
        "peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "unit = 2**20 if sys.platform == 'darwin' else 2**10\n"
        "print(json.dumps([time.process_time() - begun, peak / unit]))\n"
    )
    answer = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
    used_s, peak_mib = json.loads(answer.stdout)
    row = _row(f"the full map in a fresh process; peak memory {peak_mib:.0f} MiB", used_s)
    return [dict(row, peak_memory_mib=peak_mib)]


def map_sizes() -> list[dict[str, Any]]:
    """Cost of a cell against their number, up to 10^5."""
    return _cost_against_size((10**3, 10**4, 10**5))


def large_maps() -> list[dict[str, Any]]:
    """The same up to 10^7, which takes minutes."""
    return _cost_against_size((10**5, 10**6, 10**7))[1:]


def _cost_against_size(sizes: Sequence[int]) -> list[dict[str, Any]]:
    rows, cells, times = [], [], []
    for size in sizes:
        latitudes = np.linspace(-90.0, 90.0, max(round(size / len(_DAYS)), 2))
        count = len(latitudes) * len(_DAYS)
        parts = np.array_split(latitudes, max(1, count // 10**5))

        def work(parts: Any = parts) -> None:
            for part in parts:
                _map(part, _DAYS)

        used = best_time_s(work, 5) if size <= 10**4 else _once_cpu_s(work)
        rows.append(_row(f"{count} cells: {1e6 * used / count:.1f} us for each", used))
        cells.append(count)
        times.append(used)
    slope = float(np.polyfit(np.log(cells), np.log(times), 1)[0])
    slope_text = f"; slope of log time against log cells {slope:.3f} from {cells[0]} cells"
    rows[-1]["work"] += slope_text
    rows[-1]["slope"] = slope
    return rows


def _once_cpu_s(work: Callable[[], Any]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun
