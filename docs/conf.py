"""Settings of the documentation site: ``make docs`` builds it in ``docs/_build/html``.

The pages are also read on GitHub, so they are plain Markdown; what only the site can show, such as
cards and the tree of pages, is in the ``.rst`` files. The built site asks no other server for
anything and works from a folder: MathJax is in ``_static``, and ``check_site.py`` looks for the
rest.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

import solar

project = "solar-uav-sizing"
author = "The solar-uav-sizing developers"
copyright = author
version = release = solar.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "myst_nb",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "docstrings",
    "generated_tables",
    "github_pages",
]
# docs/index.md is the table of contents on GitHub; index.rst is that of the site.
templates_path = ["_templates"]
exclude_patterns = ["_build", "index.md", "gallery/*.ipynb", "gallery/*.py", "_templates", "tables"]

# Markdown as GitHub reads it: headings are anchors, formulas stand between dollars.
myst_enable_extensions = ["amsmath", "colon_fence", "dollarmath"]
myst_heading_anchors = 4
myst_dmath_double_inline = True

# The notebook is run at every build, and a cell that fails fails the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300

# From the npm package mathjax; formulas as SVG need no fonts, which file:// may refuse.
mathjax_path = "mathjax/tex-svg.js"
mathjax3_config = {"options": {"enableMenu": False}}

# The public names are loaded when they are first asked for; autosummary asks for each by its name.
autosummary_generate = True
autosummary_ignore_module_all = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {
    "members": True,
    "exclude-members": "model_config, model_post_init",
}
napoleon_google_docstring = False
napoleon_use_ivar = False
napoleon_use_rtype = False
# Attributes as a list like that of the parameters.
napoleon_custom_sections = [("Source", "notes_style"), ("Attributes", "params_style")]

copybutton_prompt_text = "$ "
copybutton_line_continuation_character = "\\"

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    # Two take a minute, their figures are on the pages that show the studies; one needs OpenMDAO.
    "filename_pattern": r"(?<!climb_gain)(?<!span_for_a_season)(?<!openmdao_component)\.py$",
    "within_subsection_order": "ExampleTitleSortKey",
    # As a user runs them: python examples/NAME.py figure.png
    "reset_argv": "example_figures.figure_file",
    "image_scrapers": ("example_figures.scrape_figure",),
    "reset_modules": (),
    "remove_config_comments": True,
    "show_memory": False,
    "min_reported_time": 1e6,
    # Its table of durations would be drawn by scripts from other servers.
    "write_computation_times": False,
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
}

html_theme = "pydata_sphinx_theme"
html_title = project
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_search_scorer = str(Path(__file__).parent / "_static" / "scorer.js")
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "logo": {"text": project},
    "header_links_before_dropdown": 7,
    "navbar_align": "left",
    "show_toc_level": 2,
    "show_prev_next": True,
    "footer_start": ["copyright"],
    "footer_end": [],
}
# Pages without others below them have nothing to show beside them.
html_sidebars = {page: [] for page in ("index", "get-started", "validation", "faq", "nomenclature")}
html_context = {"default_mode": "auto"}
