"""What tests on the bench say about an aircraft: keys of its file, with confidence intervals.

* ``tables``: CSV files of the tests and their templates
* ``modules``, ``propulsion``, ``glide``, ``capacity``: what each kind of test determines
* ``result``: all tests together, and the aircraft with their values
"""
