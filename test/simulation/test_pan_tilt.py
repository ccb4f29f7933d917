"""A pan/tilt does what it is told: late, behind, and within its limits."""

from __future__ import annotations

from blob_tracker.simulation.pan_tilt import Joints, PanTilt
import numpy as np
import pytest

FAST = Joints(delay=0.025, frequency=10.0, damping=0.7, rate=1e3, acceleration=1e6)


def driven(joints: Joints, times: np.ndarray, goal: float) -> np.ndarray:
    """Return the pan at the times after one command at 0."""
    pan_tilt = PanTilt(joints)
    pan_tilt.command(goal, 0.0)
    angles = []
    for time in times:
        pan_tilt.advance(float(time))
        angles.append(pan_tilt.angles[0])
    return np.array(angles)


def test_a_step_is_the_text_book_s() -> None:
    """1 - e^(-d w t) (cos + d / sqrt(1 - d^2) sin), from the end of the delay on: exactly."""
    times = np.linspace(0.0, 0.4, 173)
    since = np.maximum(times - 0.025, 0.0)
    own = 2.0 * np.pi * 10.0 * np.sqrt(1.0 - 0.7**2)
    fade = np.exp(-0.7 * 2.0 * np.pi * 10.0 * since)
    asked = 1.0 - fade * (np.cos(own * since) + 0.7 / np.sqrt(1 - 0.7**2) * np.sin(own * since))
    assert driven(FAST, times, 1.0) == pytest.approx(asked, abs=1e-9)


def test_behind_a_steady_command_it_lags_as_it_says() -> None:
    """Delay, lag and half of the time between two commands of 1 ms."""
    pan_tilt = PanTilt(FAST)
    for step in range(2000):
        pan_tilt.advance(1e-3 * step)
        pan_tilt.command(0.1 * pan_tilt.time, -0.1 * pan_tilt.time)
    behind = 0.1 * pan_tilt.time - pan_tilt.angles[0]
    assert behind / 0.1 == pytest.approx(FAST.delay + FAST.lag + 5e-4, abs=6e-4)
    assert pan_tilt.angles[1] == pytest.approx(-pan_tilt.angles[0])


def test_it_keeps_within_rate_and_acceleration() -> None:
    """And gets there all the same, past the goal by no more than the loop alone would be."""
    times = np.arange(0.0, 4.0, 0.01)
    angles = driven(Joints(rate=0.5, acceleration=2.0), times, 1.0)
    speeds = np.diff(angles) / 0.01
    assert speeds.max() == pytest.approx(0.5, rel=1e-6)
    assert np.abs(np.diff(speeds)).max() / 0.01 <= 2.0 * (1.0 + 1e-6)
    assert angles[-1] == pytest.approx(1.0, abs=1e-4)
    assert angles.max() < 1.0 + 1e-3


def test_a_fast_swing_within_the_limits_is_followed() -> None:
    """0.6 rad/s and 1.8 rad/s^2, sent in steps: never further behind than delay and lag."""
    joints = Joints(acceleration=5.0)
    pan_tilt, worst = PanTilt(joints), 0.0
    for step in range(2000):
        time = 5e-3 * step
        pan_tilt.advance(time)
        pan_tilt.command(0.2 * np.sin(3.0 * time), 0.0)
        late = time - joints.delay - joints.lag - 0.0025
        if time > 0.5:
            worst = max(worst, abs(pan_tilt.angles[0] - 0.2 * np.sin(3.0 * late)))
    # What the loop's second order leaves, 1.8 rad/s^2 over w^2, 0.2 mrad, and the steps' ripple.
    assert worst < 1e-3


def test_encoders_round() -> None:
    """What is reported, and what is gone to."""
    pan_tilt = PanTilt(Joints(resolution=1e-3))
    pan_tilt.command(0.01234, 0.0)
    pan_tilt.advance(2.0)
    assert pan_tilt.angles[0] == pytest.approx(0.012, abs=1e-6)
    assert pan_tilt.reported()[0] == pytest.approx(0.012, abs=1e-12)


@pytest.mark.parametrize('wrong', [
    {'delay': -0.1}, {'frequency': 0.0}, {'damping': 1.0}, {'rate': np.nan}, {'resolution': -1.0},
])
def test_what_cannot_be_is_refused(wrong: dict[str, float]) -> None:
    """By name."""
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Joints(**wrong)


def test_a_command_that_is_no_number_is_refused() -> None:
    """A runaway begins with one."""
    with pytest.raises(ValueError, match='finite'):
        PanTilt(Joints()).command(np.nan, 0.0)


def test_it_knows_where_it_was() -> None:
    """As one that was driven up to there, in a swing and at the motors' limits; not long after."""
    for joints in (Joints(delay=0.0), Joints(delay=0.0, acceleration=0.2)):
        once = PanTilt(joints)
        once.command(0.05, -0.02)
        once.advance(0.101)
        for time in (0.0611, 0.0805, 0.1, 0.101):
            stopped = PanTilt(joints)
            stopped.command(0.05, -0.02)
            stopped.advance(time)
            # 1 urad: a step in which a limit begins to hold is no cubic.
            assert once.at(np.array([time]))[0] == pytest.approx(stopped.angles, abs=1e-6)
    with pytest.raises(ValueError, match='drive it up to the last one'):
        once.at(np.array([0.102]))
    with pytest.raises(ValueError, match=r'known are 0\.05'):
        once.at(np.array([0.01]))
