"""What came of each frame as a table: CSV."""

from __future__ import annotations

import csv
from pathlib import Path

from blob_tracker.commands.track.outcome import Outcome
import numpy as np

COLUMNS = (
    'frame', 'stamp_s', 'light', 'azimuth_mrad', 'elevation_mrad', 'sigma_azimuth_mrad',
    'sigma_elevation_mrad', 'covariance_mrad2', 'x_px', 'y_px', 'sigma_x_px', 'sigma_y_px',
    'covariance_px2', 'snr', 'chi2', 'saturated', 'reason', 'warning',
)


class Table:
    """
    Write a row for each light of each frame, and one with the reason if there is none.

    The numbers have all their digits: read again they are the same to the last bit.

    Parameters
    ----------
    path : Path
        The CSV to write.

    """

    def __init__(self, path: Path) -> None:
        # Line by line: what is done is there, however the run ends.
        self._file = path.open('w', newline='', buffering=1, encoding='utf-8')
        self._rows = csv.writer(self._file, lineterminator='\n')
        self._rows.writerow(COLUMNS)

    def add(self, outcome: Outcome) -> None:
        """Write the row of an outcome."""
        seconds, nanoseconds = divmod(outcome.stamp_ns, 10**9)
        row: list[object] = [outcome.name, f'{seconds}.{nanoseconds:09d}', outcome.light]
        location, bearing = outcome.location, outcome.bearing
        if bearing is None:
            row += [''] * 5
        else:
            row += [bearing.azimuth, bearing.elevation, *_spread(bearing.covariance)]
        if location is None:
            row += [''] * 8 + [outcome.reason, '']
        else:
            row += [
                location.x, location.y, *_spread(location.covariance), location.snr,
                location.chi2, location.saturated, '', location.warning,
            ]
        self._rows.writerow(row)

    def close(self) -> None:
        """End the file."""
        self._file.close()


def _spread(covariance: np.ndarray) -> tuple[float, float, float]:
    """Return both standard deviations and the covariance."""
    first, second = np.sqrt(covariance.diagonal())
    return float(first), float(second), float(covariance[0, 1])
