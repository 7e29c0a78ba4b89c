"""Propellers, motors, gears and controllers, at an operating point.

* ``propeller``: coefficients of thrust and power, as tables, which ``propeller_files`` reads, or by
  diameter, pitch and number of blades
* ``electric``: motor, gear, controller
* ``operating_point``: all of them together at a thrust, an airspeed and an air
"""
