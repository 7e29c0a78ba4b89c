"""Mission layer: what an aircraft is asked to do, where, when and in which weather.

Mission definitions and their library, and the day and night energy balance of an
aircraft flying one. Built on :mod:`solar` only.
"""
