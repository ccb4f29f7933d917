"""What no method is given, and what is no location whichever method says so."""

from blob_tracker.location.contract import flag_invalid, LARGEST_DN, validate
from blob_tracker.location.estimates import Failure
import numpy as np
import pytest

SOUND = {'x': 4.0, 'y': 4.0, 'background': 10.0, 'sigma': 1.5, 'snr': 20.0, 'chi2': 1.0}


def test_windows_that_no_method_can_work_on() -> None:
    """Each with its reason; an unlit window may be flat."""
    lit = np.arange(9.0 * 6).reshape(6, 3, 3)
    unlit = np.full_like(lit, 5.0)
    lit[1, 1, 1], lit[2], lit[3], unlit[4, 0, 0] = np.nan, 7.0, 300.0, 1.5 * LARGEST_DN
    invalid = np.zeros(6, np.uint8)
    assert flag_invalid(lit, unlit, 255.0, invalid)
    assert invalid.tolist() == [
        Failure.NONE, Failure.NOT_FINITE, Failure.FLAT, Failure.SATURATED, Failure.NOT_FINITE,
        Failure.NONE,
    ]
    assert not flag_invalid(lit[:1], unlit[:1], 255.0, np.zeros(1, np.uint8))


@pytest.mark.parametrize('name, value, failure', [
    ('x', 4.0, Failure.NONE), ('x', 8.6, Failure.OUTSIDE), ('y', -0.6, Failure.OUTSIDE),
    ('sigma', np.nan, Failure.NOT_CONVERGED), ('chi2', np.inf, Failure.NOT_CONVERGED),
])
def test_what_is_no_location(name: str, value: float, failure: Failure) -> None:
    """Outside of its window, or no number."""
    given = {key: np.array([number]) for key, number in {**SOUND, name: value}.items()}
    found = np.zeros(1, np.uint8)
    validate(
        given['x'], given['y'], np.eye(2)[None], np.array([90.0]), given['background'],
        given['sigma'], given['snr'], given['chi2'], (9, 9), np.zeros(1, np.uint8), found,
    )
    assert found[0] == failure


@pytest.mark.parametrize('xx, xy, yy', [(7.0, 0.0, 0.01), (0.02, 0.0, 7.0), (9.0, 8.9, 9.0)])
def test_a_place_that_is_anywhere_in_the_window_is_none(xx: float, xy: float, yy: float) -> None:
    """Along one axis is enough: a place of which nothing is known has a variance of 81/12."""
    given = {key: np.array([number]) for key, number in SOUND.items()}
    found = np.zeros(1, np.uint8)
    validate(
        given['x'], given['y'], np.array([[[xx, xy], [xy, yy]]]), np.array([90.0]),
        given['background'], given['sigma'], given['snr'], given['chi2'], (9, 9),
        np.zeros(1, np.uint8), found,
    )
    assert found[0] == Failure.VAGUE
