"""The command ``solar-uav``: options, checks and one module per group of commands."""
