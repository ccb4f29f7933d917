"""A flash that switches while the rows of the light are exposed."""

from blob_tracker.location import locate_batch
from blob_tracker.simulation.sensor import expose
import numpy as np
import pytest
from support.flashes import NOISE, pairs, SATURATION


def ramp(rows_of_it, at):
    """Return the share of each row: from 1 to 0 over so many rows, `at` in the light's own."""
    return lambda rows, y: np.clip(at - (rows - y) / rows_of_it, 0.0, 1.0)


def rest(rows_of_it, at):
    """Return what the ramp leaves."""
    return lambda rows, y: 1.0 - ramp(rows_of_it, at)(rows, y)


def test_a_light_that_moves_past_the_cut_is_placed_or_doubted():
    """Fit it from several beginnings: each frame has its own cut, and few rows tell where."""
    random = np.random.default_rng(7)
    rows, columns = np.mgrid[0:13, 0:13].astype(float)
    squares = []
    for _ in range(40):
        (x, y), angle = 6.0 + random.uniform(-0.5, 0.5, 2), random.uniform(0.0, 2.0 * np.pi)
        at, images = random.uniform(0.6, 0.95), []
        then = x + 3.0 * np.cos(angle), y + 3.0 * np.sin(angle)
        for place, lit in (((x, y), True), (then, False)):
            share = ramp(8, at)(rows, place[1])
            light = np.exp(-((columns - place[0]) ** 2 + (rows - place[1]) ** 2) / 4.5)
            images.append(expose(
                30.0 + 120.0 * (share if lit else 1.0 - share) * light, NOISE, random,
                saturation=SATURATION,
            )[None])
        found = locate_batch(*images, noise=NOISE, saturation=SATURATION)
        if 'switches' in found.warnings.get(0, ''):
            squares.append((found.y[0] - y) ** 2 / found.covariance[0, 1, 1])
    assert len(squares) > 20
    # 80 with the curvature at the first top that is found.
    assert np.mean(squares) < 6.0


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
