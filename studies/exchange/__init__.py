"""Designs for other tools: geometry, files of a design, schemas of the files.

* :mod:`.files`: files of a design, LaTeX among them
* :mod:`.airplane`: lifting surfaces of an aircraft, for AeroSandbox, AVL and OpenVSP
* :mod:`.schema`: JSON Schema of aircraft and mission files
"""
