"""Designs for other tools: geometry, files of a design, schemas of the files.

* :mod:`.geometry`: lifting surfaces of an aircraft
* :mod:`.files`: files of a design, LaTeX among them
* :mod:`.airplane`: the same for AeroSandbox, AVL and OpenVSP
* :mod:`.schema`: JSON Schema of aircraft and mission files
"""
