"""Propellers, motors, gears and controllers, at an operating point.

* ``propeller``: coefficients of thrust and power, as tables; ``propeller_files`` reads them
* ``blade_elements``: propeller by diameter, pitch and number of blades
* ``electric``: motor, gear, controller
* ``operating_point``: all of them together at a thrust, an airspeed and an air
"""
