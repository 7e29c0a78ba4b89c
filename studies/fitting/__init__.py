"""What a flight log says about an aircraft: parameters fitted to it, with confidence intervals.

* ``flight``: the fit, and how it prints itself; ``parameters``: what may be fitted
* ``channels``: measured and modelled solar power, load and charge
* ``estimation``: what a channel determines; ``least_squares``: values, intervals, several flights
* ``flight_tables``: what each flight says
* ``files``: aircraft files with provenance; ``plots``: figure
* ``prediction``: another flight, predicted from the fit; ``synthetic``: flights of known truth
* ``calibration``: a parametric aircraft that weighs and consumes what a measured one does
"""
