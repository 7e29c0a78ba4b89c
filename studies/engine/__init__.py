"""Long computations in chunks: in parallel, resumable, not lost by one bad cell.

* ``run``: studies, their jobs and results; ``workers``: who computes; ``chunk_store``: what is kept
"""
