"""
Make what ament looks up, and `ros2 run` starts, lead to the source tree: `make check` needs it.

Usage: overlay.py FOLDER
FOLDER is made anew; as AMENT_PREFIX_PATH it stands in for the folder that colcon installs to.
"""

from __future__ import annotations

from pathlib import Path
import shutil
import sys

ROOT = Path(__file__).resolve().parents[1]
NAME = 'blob_tracker'
SCRIPT = """\
#!{python}
import sys
sys.path.insert(0, {root!r})
from {package}.nodes.start import {node}
sys.exit({node}())
"""


def make_overlay(folder: Path) -> None:
    """Link the package's share and its mark in the index, and write a script for each node."""
    sys.path.insert(0, str(ROOT))
    from blob_tracker.nodes import NODES

    shutil.rmtree(folder, ignore_errors=True)
    mark = folder / 'share/ament_index/resource_index/packages' / NAME
    scripts = folder / 'lib' / NAME
    for parent in (mark.parent, scripts):
        parent.mkdir(parents=True)
    mark.symlink_to(ROOT / 'resource' / NAME)
    # package.xml, config/, launch/ and examples/ are named alike in both.
    (folder / 'share' / NAME).symlink_to(ROOT)
    for node in NODES:
        script = scripts / node
        script.write_text(
            SCRIPT.format(python=sys.executable, root=str(ROOT), package=NAME, node=node)
        )
        script.chmod(0o755)


if __name__ == '__main__':
    make_overlay(Path(sys.argv[1]))
