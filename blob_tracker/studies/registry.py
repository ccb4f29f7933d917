"""All studies by name, in the order of the thesis and then beyond it."""

from __future__ import annotations

import re

from blob_tracker.studies import (
    beyond,
    causes,
    centroid_sweeps,
    chapter_2,
    chapter_5,
    chapter_5_artefact,
    chapter_5_calibration,
    digit_tables,
    error_surface,
    growing_target,
    locale_table,
    log_linear_sweeps,
    noise_tables,
    snr_tables,
    three_gaussian_sweeps,
    trailing_edge,
)
from blob_tracker.studies.study import Study

BEYOND = (9, '', 0)
ALL: tuple[Study, ...] = (
    *chapter_2.STUDIES,
    *centroid_sweeps.STUDIES,
    *digit_tables.STUDIES,
    *noise_tables.STUDIES,
    *snr_tables.STUDIES,
    *log_linear_sweeps.STUDIES,
    *error_surface.STUDIES,
    *three_gaussian_sweeps.STUDIES,
    chapter_5_calibration.STUDY, chapter_5_artefact.STUDY, *chapter_5.STUDIES,
    causes.STUDY, beyond.STUDY, trailing_edge.STUDY, locale_table.STUDY, growing_target.STUDY,
)


def _place(study: Study) -> tuple[int, str, int]:
    """Return the place of a study in the thesis: chapter, figure or table, number."""
    found = re.fullmatch(r'(figure|table)_(\d+)_(\d+)', study.name)
    return (int(found[2]), found[1], int(found[3])) if found else BEYOND


STUDIES = {study.name: study for study in sorted(ALL, key=_place)}
