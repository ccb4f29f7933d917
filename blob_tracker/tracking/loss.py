"""When a track is not told, and why."""

from __future__ import annotations

from blob_tracker.tracking.hypothesis import CONFIRMING, Hypothesis, Situation, SUSPECTED
from blob_tracker.tracking.packed import largest_deviation


def not_yet(oldest_ns: int | None, stamp_ns: int) -> str:
    """Return why there is no track at an instant, by the oldest bearing that is kept."""
    if oldest_ns is None:
        return 'no bearing has come'
    return (
        f'the instant is {1e-9 * (oldest_ns - stamp_ns):.3f} s before the oldest '
        'bearing that is kept'
    )


def lost(
    track: Hypothesis, situation: Situation, stamp_ns: int, coast: float, max_sigma: float
) -> str:
    """Return why the track of a situation is not told at an instant; empty if it may be."""
    age = 1e-9 * (stamp_ns - track.stamp_ns)
    if age > coast:
        return f'the last bearing is {age:.3f} s ago; coast is {coast:g} s'
    rival = situation.rival
    if rival is not None and rival.bearings >= SUSPECTED:
        return f'the last {rival.bearings} bearings agree with each other and not with the track'
    if track.confirmed:
        return ''
    reason = f'only {track.bearings} of the {CONFIRMING} bearings that must agree have come'
    if situation.unsure:
        reason += (
            f'; the track before was sure to {situation.unsure:.1f} mrad when its next bearing '
            f'came, max_sigma is {max_sigma:g}'
        )
    return reason


def unsure(predicted: Hypothesis, max_sigma: float) -> str:
    """Return that a prediction is too unsure to be told; empty if it is not."""
    sigma = largest_deviation(predicted.state)
    if sigma <= max_sigma:
        return ''
    return (
        f'the standard deviation of the direction is {sigma:.2f} mrad; max_sigma is '
        f'{max_sigma:g} mrad'
    )
