"""All studies by name, in the order of the thesis and then beyond it."""

from __future__ import annotations

from blob_tracker.studies.study import Study

ALL: tuple[Study, ...] = ()
STUDIES: dict[str, Study] = {study.name: study for study in ALL}
