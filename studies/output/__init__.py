"""What results look like: on the terminal, in figures, in files.

* ``terminal``: shows what describes itself; ``cycle_plots``, ``cells``: figures
* ``run_folder``, ``formats``: folders and files of a run
"""
