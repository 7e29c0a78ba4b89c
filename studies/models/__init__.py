"""Solar power models side by side: what they predict, and what each would have built.

* ``comparison``: predictions, seasons and designs by model and correction
* ``component_efficiencies``: what drives the Full Model; ``transfer``: its ratio to the others
"""
