"""The growth of the covariance against scatter that is drawn as the model has it."""

from __future__ import annotations

from blob_tracker.calibration.view_scatter import variance_growth
import numpy as np
import pytest

VIEWS, PARAMETERS, POINTS = 20, 6, 100
NOTHING = np.zeros(PARAMETERS)  # of a prior
SCALES = 10.0 ** np.arange(-2.0, 4.0)  # as of coefficients beside focal lengths


def draw(
    random: np.random.Generator, together: float, views: int = VIEWS
) -> tuple[np.ndarray, np.ndarray, float]:
    """
    Fit a linear model and return its parts.

    Each residual has a variance of 1, and each parameter's column a part of its own in each view
    with a standard deviation of `together` times that of the column's share of the noise.
    """
    columns = random.normal(size=(views, POINTS, PARAMETERS)) * SCALES
    information = columns.transpose(0, 2, 1) @ columns
    noise = random.normal(size=(views, POINTS))
    common = random.normal(0.0, together, (views, PARAMETERS)) / (SCALES * np.sqrt(POINTS))
    data = noise + (columns @ common[..., None])[..., 0]
    pulls = (columns.transpose(0, 2, 1) @ data[..., None])[..., 0]
    step = np.linalg.solve(information.sum(axis=0) / np.outer(SCALES, SCALES),
                           pulls.sum(axis=0) / SCALES) / SCALES
    residuals = data - columns @ step
    pulls = (columns.transpose(0, 2, 1) @ residuals[..., None])[..., 0]
    return information, pulls, float((residuals**2).sum()) / (views * POINTS - PARAMETERS)


@pytest.mark.parametrize('views', [3, 20])
def test_independent_errors_need_no_growth(views: int) -> None:
    """In 499 of 500 draws: of 30 seeds none has more than 3 of 600, and all of them 34 or 28."""
    random = np.random.default_rng(1)
    grown = [variance_growth(*draw(random, 0.0, views), NOTHING) > 1.0 for _ in range(600)]
    assert sum(grown) <= 4


def test_what_is_known_before_leaves_the_views_less_to_tell() -> None:
    """A parameter that the prior holds is not pulled: the scatter is that of the others."""
    random = np.random.default_rng(3)
    information, pulls, variance = draw(random, 3.0)
    held = NOTHING + 1e12 * np.append(np.zeros(PARAMETERS - 1), SCALES[-1] ** 2)
    rest = variance_growth(information[:, :-1, :-1], pulls[:, :-1], variance, NOTHING[:-1])
    assert variance_growth(information, pulls, variance, held) == pytest.approx(rest, rel=1e-3)


def test_growth_is_that_of_the_pulls() -> None:
    """Pulls with a variance of 1 + 9, residuals with 1 + 9 x 6 / 100: 10 / 1.54 = 6.5."""
    random = np.random.default_rng(2)
    growths = [variance_growth(*draw(random, 3.0), NOTHING) for _ in range(40)]
    # Each is known to sqrt(2 / (19 x 6)) = 13 %; a view's weight in the fit takes 2 % off.
    assert np.mean(growths) == pytest.approx(6.5, rel=0.08)


def test_one_view_tells_nothing() -> None:
    """Its pull is zero at the fit, whatever its errors are."""
    information = np.eye(3)[None]
    assert variance_growth(information, np.zeros((1, 3)), 1.0, np.zeros(3)) == 1.0
