"""All studies by name, in the order of the thesis and then beyond it."""

from __future__ import annotations

import re

from blob_tracker.studies.beyond import (
    causes,
    default_pipeline,
    growing_target,
    locale_table,
    prediction,
    servo,
    trailing_edge,
)
from blob_tracker.studies.chapter_5 import known_shifts, steps, trailing_edge_row
from blob_tracker.studies.chapters_2_to_4 import (
    centroid_sweeps,
    digit_tables,
    error_surface,
    imaging,
    log_linear_sweeps,
    noise_tables,
    snr_tables,
    three_gaussian_sweeps,
)
from blob_tracker.studies.study import Study

BEYOND = (9, '', 0)
ALL: tuple[Study, ...] = (
    *imaging.STUDIES,
    *centroid_sweeps.STUDIES,
    *digit_tables.STUDIES,
    *noise_tables.STUDIES,
    *snr_tables.STUDIES,
    *log_linear_sweeps.STUDIES,
    *error_surface.STUDIES,
    *three_gaussian_sweeps.STUDIES,
    *steps.STUDIES,
    known_shifts.STUDY,
    trailing_edge_row.STUDY,
    causes.STUDY,
    default_pipeline.STUDY,
    trailing_edge.STUDY,
    locale_table.STUDY,
    growing_target.STUDY,
    prediction.STUDY,
    servo.STUDY,
)


def _place(study: Study) -> tuple[int, str, int]:
    """Return the place of a study in the thesis: chapter, figure or table, number."""
    found = re.fullmatch(r'(figure|table)_(\d+)_(\d+)', study.name)
    return (int(found[2]), found[1], int(found[3])) if found else BEYOND


STUDIES = {study.name: study for study in sorted(ALL, key=_place)}
