"""How `make docs` builds the pages of this folder: one site, or with ``-t print`` one long page for a PDF.

The pages are plain Markdown that reads as well in the repository. What a site needs beyond it is added here: its list of pages
comes from README.md, and links that leave this folder lead to the site's own copy. Nothing is asked of another host.
"""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

DOCS = Path(__file__).parent
_project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text())["project"]

project = _project["name"]
author = "the authors of irtiming"
project_copyright = author
version = release = _project["version"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
exclude_patterns = ["README.md"]
myst_heading_anchors = 4
suppress_warnings = ["myst.xref_ambiguous"]
smartquotes = False  # -- is a dash of an option, not of a sentence
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|pandas|collections|pathlib|typing)\..*|tuple\[float"),  # of others
    ("py:class", r"irtiming\.(plan|archive|records)\..*|Drawn"),  # behind the interface
]
default_role = "code"
highlight_language = "text"
add_module_names = False
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_numpy_docstring, napoleon_google_docstring = True, False

html_title = f"irtiming {version}"
html_static_path = ["_static"]
html_show_sphinx = False
html_copy_source = False
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True

if tags.has("print"):  # type: ignore[name-defined]  # noqa: F821
    html_theme, html_css_files = "basic", ["print.css"]
    extensions.remove("sphinx_copybutton")
else:
    html_theme, html_css_files = "furo", ["site.css"]
    html_theme_options = {"source_directory": "docs/", "top_of_page_buttons": []}

_OUTSIDE = {"SECURITY.md": "reference/security.md", "CHANGELOG.md": "reference/changelog.md"}
"""Files of the repository's root that the site has as pages."""


def _front_page(app: Sphinx, docname: str, source: list[str]) -> None:
    """README.md as the first page, and a hidden table of contents for each of its parts; links to the root lead to pages."""
    if docname == "index":
        text = (DOCS / "README.md").read_text()
        source[0] = text + "".join(_contents(part) for part in text.split("\n## ")[1:])
    if docname == "reference/changelog":
        source[0] = _changelog()
    if docname == "reference/security":
        source[0] = (DOCS.parent / "SECURITY.md").read_text().replace("](docs/", "](../")
    up = "../" * docname.count("/")
    for name, page in _OUTSIDE.items():
        source[0] = re.sub(rf"\]\((?:\.\./)*{re.escape(name)}", f"]({up}{page}", source[0])


def _changelog() -> str:
    """What CHANGELOG.md will say at the next release; links from the root."""
    script = [sys.executable, DOCS.parent / "scripts" / "changelog"]
    done = subprocess.run(script, capture_output=True, text=True, check=True)
    return done.stdout.replace("](docs/", "](../")


def _contents(part: str) -> str:
    """A hidden table of contents with the pages that a part of README.md links to, in its order."""
    caption, _, text = part.partition("\n")
    caption = re.split(r":| that ", caption)[0]
    links = re.findall(r"\]\(((?:\.\./)*[\w/.-]+)\.(?:md|rst)\)", text)
    pages = dict.fromkeys(_OUTSIDE.get(link.removeprefix("../") + ".md", link).removesuffix(".md") for link in links)
    return "\n\n```{toctree}\n:hidden:\n:caption: " + caption + "\n\n" + "\n".join(pages) + "\n```\n"


_docstrings: dict[str, list[str]] = {}


def _before_napoleon(app: Sphinx, what: str, name: str, *rest: object) -> None:
    """Keep the docstring of a property: a colon in its first line would be read as the end of a type."""
    if what == "property":
        _docstrings[name] = list(rest[-1])  # type: ignore[call-overload]


def _after_napoleon(app: Sphinx, what: str, name: str, *rest: object) -> None:
    """Give a property its docstring back."""
    if what == "property":
        rest[-1][:] = _docstrings.pop(name)  # type: ignore[index]


def _dashes(app: Sphinx, tree: nodes.document, docname: str) -> None:
    """A dash between a parameter and its description, which Sphinx leaves to the quotation marks that are switched off."""
    for text in list(tree.findall(lambda node: isinstance(node, nodes.Text) and node == " -- ")):
        text.parent.replace(text, nodes.Text(" – "))


class _Translator(HTML5Translator):
    """Tables in a box of their own, which scrolls where a screen is narrow."""

    def visit_table(self, node: nodes.Element) -> None:
        self.body.append('<div class="wide">')
        super().visit_table(node)

    def depart_table(self, node: nodes.Element) -> None:
        super().depart_table(node)
        self.body.append("</div>")


def setup(app: Sphinx) -> dict[str, bool]:
    """What this site does beyond Sphinx."""
    app.connect("source-read", _front_page)
    app.connect("doctree-resolved", _dashes)
    app.connect("autodoc-process-docstring", _before_napoleon, priority=400)
    app.connect("autodoc-process-docstring", _after_napoleon, priority=600)
    app.set_translator("html", _Translator)
    app.set_translator("singlehtml", _Translator)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
