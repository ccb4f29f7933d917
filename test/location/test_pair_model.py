"""Means and slopes of the models of a pair, and their likelihood."""

from dataclasses import replace

from blob_tracker.location import pair_model, shape_model
from blob_tracker.location.hypotheses import choose, Fit, History, Pair
from blob_tracker.location.pair_likelihood import climb, fill_equations, log_likelihood
from blob_tracker.location.texture_field import log_likelihood_of_texture
import numpy as np
import pytest
from scipy.stats import multivariate_normal
from support.flashes import evenly, NOISE, pairs

PULSE = [4.3, 3.8, 100.0, 30.0, 1.4]
MODELS = [
    (pair_model.fill_one_pulse, PULSE),
    (pair_model.fill_dark_ghost, [*PULSE, -0.8, 0.4, 20.0]),
    (pair_model.fill_static_ghost, [*PULSE, -0.8, 0.4, 20.0]),
    (pair_model.fill_switched, [*PULSE, 0.3, -0.2, 0.62, 0.083, 0.04]),
    (pair_model.fill_elliptical, [*PULSE, 1.7]),
    (shape_model.fill_glow, [*PULSE, 20.0, 3.0, -2.0]),
    (shape_model.fill_glow, [*PULSE, 20.0, 3.0, -2.0, -4.0, 1.0, -3.0]),
]


@pytest.mark.parametrize(('model', 'theta'), MODELS)
def test_slopes_are_those_of_the_means(model, theta):
    """Agree with central differences."""
    theta = np.array(theta)

    def fill(at):
        means, slopes = np.zeros((2, 9, 10)), np.zeros((len(theta), 2, 9, 10))
        model(at, means, slopes)
        return means, slopes

    slopes = fill(theta)[1]
    for p, slope in enumerate(slopes):
        step = 1e-5 * np.eye(len(theta))[p]
        difference = (fill(theta + step)[0] - fill(theta - step)[0]) / 2e-5
        np.testing.assert_allclose(slope, difference, atol=1e-5)


def test_likelihood_of_a_pair_is_that_of_its_normal_distribution():
    """Agree with the density written out, texture and clipped pixels included."""
    random = np.random.default_rng(1)
    means = random.uniform(20.0, 90.0, (2, 3, 4))
    pixels = means + random.normal(size=means.shape)
    usable = np.ones(means.shape, dtype=bool)
    usable[0, 1, 1] = usable[1, 2, 3] = False
    shot, floor, texture = 0.1, 1.2, 2.5
    covariance = np.diag((means * shot + floor).ravel())
    for k in range(12):
        covariance[k, 12 + k] = covariance[12 + k, k] = texture
        covariance[k, k] += texture
        covariance[12 + k, 12 + k] += texture
    kept = usable.ravel()
    expected = multivariate_normal.logpdf(
        pixels.ravel()[kept], means.ravel()[kept], covariance[np.ix_(kept, kept)]
    ) + 0.5 * kept.sum() * np.log(2.0 * np.pi)
    found, _ = log_likelihood(pixels, means, usable, shot, floor, texture)
    assert found == pytest.approx(expected)
    slopes = random.normal(size=(3, *means.shape))
    score, fisher = np.empty(3), np.empty((3, 3))
    fill_equations(pixels, means, slopes, usable, shot, floor, texture, score, fisher)
    flat = slopes.reshape(3, -1)[:, kept]
    inverse = np.linalg.inv(covariance[np.ix_(kept, kept)])
    np.testing.assert_allclose(fisher, flat @ inverse @ flat.T)
    np.testing.assert_allclose(score, flat @ inverse @ (pixels - means).ravel()[kept])


def test_likelihood_of_a_texture_is_that_of_its_gaussian_process():
    """Be the density of the likeliest of the textures, up to the grid of their strengths."""
    random = np.random.default_rng(2)
    rows, columns = np.mgrid[0:7, 0:8].reshape(2, -1)
    distance = np.subtract.outer(rows, rows) ** 2 + np.subtract.outer(columns, columns) ** 2
    variance, strength = 2.0, 3.0
    covariance = variance * (np.eye(56) + strength * np.exp(-distance / (2.0 * 2.0**2)))
    for _ in range(20):
        pixels = random.multivariate_normal(np.zeros(56), covariance).reshape(7, 8)
        at_truth = multivariate_normal.logpdf((pixels - pixels.mean()).ravel(), np.zeros(56),
                                              covariance) + 28.0 * np.log(2.0 * np.pi)
        found = log_likelihood_of_texture(pixels, variance)
        # A better strength than the true one gains half a unit a parameter, the grid loses some.
        assert at_truth - 0.6 < found < at_truth + 12.0


def test_climb_is_held_by_bounds_and_by_what_is_known():
    """Stay within bounds, and lean to a prior as its precision says."""
    seen = pairs(1, evenly(1.0), evenly(0.0))
    pair = Pair(seen.lit[0].astype(float), seen.unlit[0].astype(float), NOISE, np.inf)
    lower, upper = pair_model.bounds(pair)
    start = np.array([6.0, 6.0, 100.0, 30.0, 1.4])
    free = climb(pair, pair_model.fill_one_pulse, start, lower, upper)
    assert free.parameters == 5 + (free.texture > 0.0)
    assert free.chi2 == pytest.approx(1.0, abs=0.25)
    upper[4] = lower[4] = 1.4
    held = climb(pair, pair_model.fill_one_pulse, start, lower, upper)
    assert held.theta[4] == 1.4
    assert held.parameters == 4 + (held.texture > 0.0)
    lower, upper = pair_model.bounds(pair)
    known = np.array([1.0 / free.covariance[0, 0], 0.0, 0.0, 0.0, 0.0])
    mean = np.array([free.theta[0] + 0.02, 0.0, 0.0, 0.0, 0.0])
    led = climb(pair, pair_model.fill_one_pulse, start, lower, upper, (mean, known))
    # As well known beforehand as from the pixels: halfway.
    assert led.theta[0] == pytest.approx(free.theta[0] + 0.01, abs=0.002)
    assert led.covariance[0, 0] == pytest.approx(0.5 * free.covariance[0, 0], rel=0.05)


def fit(log_likelihood, parameters, x=0.0):
    """Return a fit that is so likely."""
    return Fit(x, 0.0, np.eye(2), 1.0, 1.0, 1.0, 10.0, 1.0, log_likelihood, parameters)


def test_an_alternative_is_heard_where_noise_would_seldom_make_it():
    """Keep the base model up to a likelihood ratio of one in 1e4."""
    base = fit(0.0, 5)
    # chi-square of 3 degrees of freedom is above 21.1 once in 1e4.
    assert choose(base, [fit(10.0, 8)], 300) is base
    likelier = fit(11.0, 8)
    assert choose(base, [likelier], 300).log_likelihood == likelier.log_likelihood


def test_alternatives_that_are_as_likely_share_the_place():
    """Be between two that are level, and as uncertain as they are apart."""
    chosen = choose(fit(0.0, 5), [fit(50.0, 8, 1.0), fit(50.0, 8, 3.0)], 300)
    assert chosen.x == pytest.approx(2.0)
    assert chosen.covariance[0, 0] == pytest.approx(2.0)
    assert choose(fit(0.0, 5), [fit(50.0, 8, 1.0), fit(70.0, 8, 3.0)], 300).x == pytest.approx(3.0)


def test_what_the_last_flashes_were_tips_the_balance():
    """Weigh two that are level by what the last flashes said for each."""
    one, other = (
        replace(fit(50.0, 8, x), model=name) for x, name in ((1.0, 'one'), (3.0, 'other'))
    )
    history = History(evidence=[{'one': -1.0, 'other': 0.0}, {'one': 0.0, 'other': -0.25}])
    chosen = choose(fit(0.0, 5), [one, other], 300, history)
    weight = 1.0 / (1.0 + np.exp(-0.75))
    assert chosen.x == pytest.approx((1.0 - weight) * 1.0 + weight * 3.0)
    assert chosen.model == 'other'
    # More than a light's whole past outdoes it: it may have become another one.
    past = History(evidence=[{'other': 0.0}] * 32)
    sure = replace(one, log_likelihood=70.0)
    assert choose(fit(0.0, 5), [sure, other], 300, past).x == pytest.approx(1.0, abs=0.01)
