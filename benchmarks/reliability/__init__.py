"""Attacks on the software, counted: wrong inputs, and faults in the middle of the work.

``python -m benchmarks.reliability faults`` and ``... inputs`` run cases and print what held;
``--keep`` also writes the record of the run, ``--markdown docs/reliability.md`` the page of all
records that were kept.
"""
