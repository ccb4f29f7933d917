"""A light that is left in the unlit frame: in the model where it is one, and only there."""

from blob_tracker.location import locate_batch
from blob_tracker.location.hypotheses import History, Motion
from blob_tracker.location.limits import cramer_rao_bound
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from support.flashes import BACKGROUND, evenly, NOISE, pairs, PEAK, SATURATION, SIGMA, SIZE

SHIFT = (-0.7, -0.4)  # px, of 0.8 px a frame
# Where the light is in the unlit frame, halfway to the last flash.
MOTION = Motion(np.array([1.4, 0.8]), 0.2)


def bound():
    """Return the rms distance that the lit window alone allows."""
    middle = (SIZE - 1) / 2
    return np.sqrt(np.trace(cramer_rao_bound(
        (SIZE, SIZE), x=middle, y=middle, sigma=SIGMA, amplitude=PEAK, background=BACKGROUND,
        noise=NOISE,
    )))


def find(seen, **options):
    """Return the estimates of pairs."""
    return locate_batch(seen.lit, seen.unlit, noise=NOISE, saturation=SATURATION, **options)


@pytest.mark.parametrize('share', [0.1, 0.2, 0.4])
def test_what_is_left_of_a_moving_light_is_in_the_model(share):
    """Be as good as the lit window alone, and name the share: lit minus unlit has NEES 7 to 87."""
    seen = pairs(400, evenly(1.0), evenly(share), shift=SHIFT)
    found = find(seen, history=lambda: History(MOTION))
    # Three standard errors of the mean of 400 chi-squares of two degrees are 0.3.
    assert seen.nees(found) == pytest.approx(2.0, abs=0.4)
    # The unlit window's background is worth something, the rms of 400 is known to 4 %.
    assert seen.rms(found) < 1.12 * bound()
    said = [each for each in found.warnings.values() if 'still on in the unlit frame' in each]
    assert len(said) > 0.98 * 400
    percent = [float(each.split('(')[1].split(' %')[0]) for each in said]
    assert np.median(percent) == pytest.approx(100.0 * share, abs=1.5)


def test_without_a_known_motion_no_answer_is_wrong():
    """Hold in the covariance what a single pair does not tell."""
    seen = pairs(400, evenly(1.0), evenly(0.2), shift=SHIFT)
    found = find(seen)
    assert 1.4 < seen.nees(found) < 2.8


def test_clean_pairs_are_left_alone():
    """Change nothing where the base model is true: a warning in 1e4 windows is a chance of one."""
    seen = pairs(8000, evenly(1.0), evenly(0.0))
    found = find(seen)
    assert len(found.warnings) <= 4  # e-3 in a Poisson of mean one
    assert seen.nees(found) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize('distance', [2.5, 4.0])
def test_a_lamp_behind_the_target_is_no_ghost(distance):
    """Tell a light that is in both windows, and take it off as before."""
    seen = pairs(300, evenly(1.0), evenly(0.0), lamp=(0.6 * distance, 0.8 * distance, 40.0))
    found = find(seen)
    assert len(found.warnings) < 3
    assert seen.nees(found) == pytest.approx(2.0, abs=0.6)


def test_a_smooth_texture_is_no_ghost():
    """Leave texture to the share of it that is taken off: few of its lumps are like a pulse."""
    random = np.random.default_rng(2)
    seen = pairs(300, evenly(1.0), evenly(0.0))
    smooth = gaussian_filter(random.standard_normal((300, SIZE + 8, SIZE + 8)), (0, 2, 2))
    texture = np.rint(8.0 * (smooth / smooth.std())[:, 4:-4, 4:-4])
    found = find(seen._replace(lit=seen.lit + texture, unlit=seen.unlit + texture))
    assert len(found.warnings) < 9
