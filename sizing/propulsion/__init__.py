"""Propellers, motors and what lies between them and the battery, at an operating point.

* ``propeller``: coefficients of thrust and power, as tables; ``propeller_files`` reads them
* ``blade_elements``: a propeller of which diameter, pitch and number of blades are known
* ``electric``: motor, gear, controller, voltage of the battery
* ``operating_point``: all of them together at a thrust, an airspeed and an air
"""
