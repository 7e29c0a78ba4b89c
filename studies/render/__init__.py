"""Results as people read them.

* ``analysis``, ``sizing``, ``uncertainty``, ``weather``: headline and blocks of what the sizing
  layer computes, as modules of studies have for theirs; with ``parts``
* ``sentences``: what needs judgement; ``words`` of requirements, ``numbers`` with their units
* ``design_sheet``: quantities of a design as a table, for papers, workbooks and reports
* ``tables``: blocks as text, Markdown, HTML, CSV and frames; ``layout`` of their text
"""
