"""Designs for other tools: geometry, tables of a design, differences, schemas of the files.

* :mod:`.geometry`: lifting surfaces of an aircraft
* :mod:`.airplane`: the same for AeroSandbox, AVL and OpenVSP
* :mod:`.design_sheet`: quantities of a design as a table, in LaTeX and Excel
* :mod:`.difference`: two designs side by side
* :mod:`.openmdao_component`: the energy balance as a component of OpenMDAO
* :mod:`.schema`: JSON Schema of aircraft and mission files
"""
