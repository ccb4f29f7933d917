"""A flash that switches while the rows of the light are exposed."""

from blob_tracker.location import locate_batch
import numpy as np
import pytest
from support.flashes import NOISE, pairs, SATURATION


def ramp(rows_of_it, at):
    """Return the share of each row: from 1 to 0 over so many rows, `at` in the light's own."""
    return lambda rows, y: np.clip(at - (rows - y) / rows_of_it, 0.0, 1.0)


def rest(rows_of_it, at):
    """Return what the ramp leaves."""
    return lambda rows, y: 1.0 - ramp(rows_of_it, at)(rows, y)


@pytest.mark.parametrize('at', [0.6, 0.8])
@pytest.mark.parametrize('rows_of_it', [8, 67, 200])
def test_rows_share_the_flash_between_the_frames(rows_of_it, at):
    """Fit both frames together: lit minus unlit is 0.1 to 3 px off at a sigma of 0.03."""
    seen = pairs(300, ramp(rows_of_it, at), rest(rows_of_it, at))
    found = locate_batch(seen.lit, seen.unlit, noise=NOISE, saturation=SATURATION)
    # Three standard errors of the mean of 300 are 0.35.
    assert seen.nees(found) == pytest.approx(2.0, abs=0.45)
    # Lit and unlit together have all of the light.
    assert seen.rms(found) < 0.05
    assert len(found.warnings) == 300
    if rows_of_it == 8:
        # Where the ramp ends beyond the pulse it may be a tilt, or a light that moves.
        said = ['flash switches' in each for each in found.warnings.values()]
        assert np.mean(said) > 0.95
