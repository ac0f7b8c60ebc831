"""How Sphinx makes the site of the pages that docs/make_site.py has put together."""

from gen_art import __version__

project = "Gen Art"
author = "the Gen Art contributors"
copyright = f"{author}, under the MIT licence"
version = release = __version__

extensions = ["myst_parser"]
myst_heading_anchors = 6  # as code hosts make them: #a-heading
myst_enable_extensions = ["deflist"]
nitpicky = True
smartquotes = False  # code stands in many sentences
highlight_language = "text"

html_theme = "furo"
html_title = "Gen Art"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#a4480f",
        "color-brand-content": "#a4480f",
        "color-brand-visited": "#7a4a8c",
    },
    "dark_css_variables": {
        "color-brand-primary": "#f2b46b",
        "color-brand-content": "#f2b46b",
        "color-brand-visited": "#d8a0c8",
    },
}
