"""The motion filter is Singer's, and its covariance true."""

from __future__ import annotations

from blob_tracker.blinking.motion import (
    begin, correct, learned_agility, mahalanobis, predict, project, STATE,
)
import numpy as np


def test_a_correction_is_that_of_kalman() -> None:
    """Against the textbook's matrices, seen off the middle of the exposure."""
    random = np.random.default_rng(1)
    root = random.standard_normal((STATE, STATE))
    covariance, state = root @ root.T, random.standard_normal(STATE)
    tau = 0.3
    h = np.kron([[1.0, tau, 0.5 * tau**2]], np.eye(2))
    seen, noise = np.array([0.4, -0.2]), np.array([[0.2, 0.05], [0.05, 0.1]])
    s = h @ covariance @ h.T + noise
    gain = covariance @ h.T @ np.linalg.inv(s)
    expected = state + gain @ (seen - h @ state)
    spread = covariance - gain @ s @ gain.T
    x, y, xx, xy, yy = project(state, covariance, tau)
    np.testing.assert_allclose([x, y], h @ state)
    correct(
        state, covariance, tau, seen[0] - x, seen[1] - y, xx + 0.2, xy + 0.05, yy + 0.1,
        np.zeros((6, 6)),
    )
    np.testing.assert_allclose(state, expected)
    np.testing.assert_allclose(covariance, spread, atol=1e-12)


def test_a_sinusoid_is_followed_through_the_dark() -> None:
    """10 px a frame at the top, reach 100 px, 0.05 px of noise, lit in 3 of 5 frames."""
    random = np.random.default_rng(2)
    state, covariance, work = np.zeros(STATE), np.zeros((STATE, STATE)), np.zeros((6, 6))
    errors, squares, accelerations, agility = [], [], [], 1.0
    for index in range(400):
        place = 100.0 * np.sin(0.1 * index) * np.array([0.8, 0.6])
        if index == 0:
            begin(state, covariance, place[0], place[1], 0.0025, 0.0, 0.0025, 10.0)
            continue
        predict(state, covariance, 1.0, agility, work)
        if index > 30:
            away = state[:2] - place
            errors.append(np.hypot(*away))
            squares.append(away @ np.linalg.solve(covariance[:2, :2], away) / 2)
        if index % 5 in (0, 1, 3):
            seen = place + 0.05 * random.standard_normal(2)
            x, y, xx, xy, yy = project(state, covariance, 0.0)
            dx, dy, sxx, syy = seen[0] - x, seen[1] - y, xx + 0.0025, yy + 0.0025
            agility = learned_agility(
                agility, mahalanobis(dx, dy, sxx, xy, syy)[0], (xx + yy) / (sxx + syy)
            )
            correct(state, covariance, 0.0, dx, dy, sxx, xy, syy, work)
        if index > 100:
            away = state[4:] + 0.01 * place
            accelerations.append(away @ np.linalg.solve(covariance[4:, 4:], away) / 2)
    assert np.median(errors) < 0.3
    # 300 of them in a row are as some 30 that are independent: 1 to 0.2, three of which are asked.
    assert 0.4 < np.mean(squares) < 1.6
    assert 0.4 < np.mean(accelerations) < 1.6
