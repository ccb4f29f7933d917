"""The QoS that a bag remembers: a list in YAML, or a text that holds such a list."""

from __future__ import annotations

from typing import Any

import yaml


def profiles(written: Any) -> list[dict[str, Any]]:
    """
    Return the offered profiles as dictionaries; none where they cannot be read.

    Parameters
    ----------
    written : list, str or None
        As metadata.yaml (a list since Jazzy), an mcap channel or a table of sqlite3 has it.

    """
    try:
        found = yaml.safe_load(written) if isinstance(written, str) else written
    except yaml.YAMLError:
        return []
    return [each for each in found if isinstance(each, dict)] if isinstance(found, list) else []
