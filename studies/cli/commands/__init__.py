"""One module for each command of ``solar-uav``, or for a few of a kind."""
