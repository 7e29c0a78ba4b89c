"""Sizing with margins: factors on solar energy and storage, and what judges a design without them.

A chance constraint, or "so many days of a record close", is no row of a program. Two numbers of a
design decide it, or nearly so: *income*, what the sun returns over the load, and *storage*, what
the battery holds over the load. The program finds the best design of one repeated day with any
factors on both; a judge flies that design without them, through thousands of draws of uncertain
inputs or through a season of a weather record. Optimisation and assessment alternate, as in
sequential optimisation and reliability assessment (SORA: Du, X., Chen, W. (2004), Sequential
optimization and reliability assessment method for efficient probabilistic design, J. Mech. Des.
126, 225-233).

* ``search``: the sizings with factors, their trials, and the verdict; the edge of enough days
* ``probability``: draws judge; one factor is the quantile of a share of the permitted failures
* ``seasons``, ``season_search``: a record judges; the search walks along the edge of enough days
* ``season_flights``: batches of designs through a season, and what it makes of one
"""
