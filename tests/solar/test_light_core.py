"""Sun, sky and modules need NumPy and pydantic, but no optimiser, no figures and no polygons."""

import subprocess
import sys

import pytest

CODE = """
import sys

for name in ("casadi", "matplotlib", "shapely"):
    sys.modules[name] = None  # its import raises ImportError

import numpy as np

import solar

for name in dir(solar):
    getattr(solar, name)

time_h = np.linspace(0.0, 24.0, 49)
declination = solar.declination(172)
sun = solar.sun_vector_ned(47.0, declination, solar.hour_angle(time_h))
times = solar.sun_times(47.0, declination)
light = solar.clear_sky(172, 47.0, np.maximum(-sun[..., 2], 0.0), altitude_m=500.0)
cell = solar.SolarCell(efficiency_stc=0.23)
for model in ("CDM", "CAM"):
    power = solar.horizontal_specific_power(
        47.0, 172, time_h, cell=cell, module_temperature_c=40.0, altitude_m=500.0, model=model
    )
    print(model, round(float(power.max())))
"""


def test_sun_sky_and_modules_work_without_casadi_matplotlib_and_shapely():
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    powers = [float(line.split()[1]) for line in done.stdout.splitlines()]
    assert powers == pytest.approx([215.0, 200.0], abs=40.0)
