"""
The documents and the Python interface as a site: `make docs`, and rosdoc2 on docs.ros.org.

The pages are those of docs/, to which doc/docs is a link; nothing is copied.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
import re
import sys
from typing import Any
from xml.etree import ElementTree

import blob_tracker

ROOT = Path(blob_tracker.__file__).resolve().parents[1]
# rosdoc2 runs a copy of this file elsewhere: what lies beside it is found by the package.
sys.path.insert(0, str(ROOT / 'doc'))

from equations import typeset  # noqa: E402, I100

project = 'blob_tracker'
author = 'blob_tracker maintainers'
release = ElementTree.parse(ROOT / 'package.xml').getroot().findtext('version')

extensions = [
    'myst_parser', 'sphinx.ext.autodoc', 'sphinx.ext.mathjax', 'sphinx.ext.napoleon',
    'sphinx.ext.viewcode',
]
MATHJAX = 'sphinx-mathjax-offline'  # which docs.ros.org, that is online anyway, does not have
if find_spec(MATHJAX):
    extensions.append(MATHJAX)
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
html_show_copyright = False
html_theme = 'sphinx_rtd_theme'
html_theme_options = {'navigation_depth': 3, 'style_external_links': True}
html_static_path = ['_static']
html_css_files = ['site.css']

myst_heading_anchors = 3
myst_enable_extensions = ['colon_fence']

autodoc_member_order = 'bysource'
autodoc_typehints = 'none'  # numpydoc's sections have them, with shapes and units
napoleon_use_ivar = True
napoleon_use_param = False  # types are words: '(N, h, w) array', no references
napoleon_use_rtype = False
napoleon_google_docstring = False

# A link to a file or folder here that is not a document: [words](path).
FILE_LINK = re.compile(
    r'(?<!!)\[`?([^\]`]+)`?\]\((?!https?:|#)(?![^)]*\.(?:md|rst)\b)([^)\s]+)\)'
)
TYPE_CELL = re.compile(r'(?<=\| )(\w+_(?:msgs|srvs)/)(?=\w+ \|)')
FILES = 'files'  # the folder of their pages
LEXERS = {
    '.py': 'python', '.yaml': 'yaml', '.rviz': 'yaml', '.xml': 'xml', '.urdf': 'xml',
    '.json': 'json', '.toml': 'toml',
}


def with_equations(
    app: object, what: str, name: str, obj: object, options: object, lines: list[str],
) -> None:
    """Typeset the equations of a docstring, in place."""
    lines[:] = typeset(lines)


def linked_file(document: str, path: str) -> Path:
    """Return what a link of a document leads to, relative to the repository."""
    return (ROOT / document).parent.joinpath(path).resolve().relative_to(ROOT)


def show_files(app: Any) -> None:
    """Write a page for each file or folder that a document links to, with what is in it."""
    source = Path(app.srcdir)
    for path in sorted(source.rglob('*.md')):
        document = path.relative_to(source).as_posix()
        for _, link in FILE_LINK.findall(path.read_text()):
            target = linked_file(document, link)
            page = source / FILES / f'{target}.rst'
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(file_page(target))


def file_page(target: Path) -> str:
    """Return the page of a file, or of all text in a folder."""
    whole = ROOT / target
    files = [whole] if whole.is_file() else sorted(
        each for each in whole.iterdir() if each.suffix in LEXERS
    )
    parts = [f':orphan:\n\n{target}\n{"=" * len(str(target))}\n']
    for file in files:
        if file != whole:
            parts.append(f'{file.name}\n{"-" * len(file.name)}\n')
        lines = ''.join(f'   {line}\n' for line in file.read_text().splitlines())
        parts.append(f'.. code-block:: {LEXERS.get(file.suffix, "text")}\n\n{lines}')
    return '\n'.join(parts)


def with_files(app: object, name: str, text: list[str]) -> None:
    """Lead links to files and folders of the repository to their pages."""
    text[0] = FILE_LINK.sub(
        lambda link: f'[{link[1]}](/{FILES}/{linked_file(name, link[2])}.rst)', text[0]
    )


def with_breaks(app: object, name: str, text: list[str]) -> None:
    """Let the types of messages in tables break after their package."""
    text[0] = TYPE_CELL.sub(r'\1<wbr>', text[0])


def without_fields(
    app: object, what: str, name: str, obj: object, skip: bool, options: object,
) -> bool | None:
    """Leave out the fields of named tuples, which their class describes."""
    return True if type(obj).__name__ == '_tuplegetter' else None


def setup(app: Any) -> None:
    """Connect to Sphinx."""
    app.connect('autodoc-process-docstring', with_equations, priority=400)
    app.connect('autodoc-skip-member', without_fields)
    app.connect('builder-inited', show_files)
    app.connect('source-read', with_files)
    app.connect('source-read', with_breaks)
