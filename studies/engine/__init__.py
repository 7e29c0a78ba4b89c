"""Long computations in chunks: in parallel, resumable, not lost by one bad cell.

* ``run``: jobs and their outcome; ``workers``: who computes; ``chunk_store``: what is kept
"""
