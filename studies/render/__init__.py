"""Results as people read them.

* ``analysis``, ``sizing``: headline and blocks, as modules of studies have for other results
* ``words`` of numbers, requirements and notes
* ``design_sheet``: quantities of a design as a table, for papers, workbooks and reports
* ``tables``: blocks as text, Markdown, HTML, CSV and frames
"""
