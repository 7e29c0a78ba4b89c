"""Trade studies over any keys of aircraft and mission.

* ``axes``: what varies; ``points``: each point analysed or sized; ``study``: all of them
* ``files``, ``plots``: NetCDF, CSV, Parquet and charts
"""
