"""Impossible numbers are told with what they must be."""

from __future__ import annotations

from typing import Any

from blob_tracker.radiometry import Led, link_budget, OpticsError, Receiver, Surroundings
import pytest


@pytest.mark.parametrize(
    'made, values, sentence',
    [
        (Led, {'power': 0.0}, 'the power, W, is 0; it must be above 0'),
        (Led, {'power': 1.0, 'efficiency': 35.0}, 'the efficiency is 35; it must be above 0 and'),
        (Led, {'power': 1.0, 'half_angle': 120.0}, 'the half-angle is 120 degrees'),
        (Led, {'power': 1.0, 'off_axis': 95.0}, 'the camera is 95 degrees off the axis'),
        (Led, {'power': 1.0, 'wavelength': 1550.0}, 'the wavelength is 1550 nm'),
        (Led, {'power': 1.0, 'flash': -1.0}, 'the flash lasts -1 s'),
        (Receiver, {'exposure': float('inf')}, 'the exposure, s, is inf'),
        (Receiver, {'filter_width': 0.0}, 'the filter is 0 nm wide'),
        (Receiver, {'read_noise': float('nan')}, 'the read noise is nan e-'),
        (Receiver, {'bits': 24}, 'the converter has 24 bits'),
        (Surroundings, {'visibility': -1.0}, 'the visibility, km, is -1'),
        (Surroundings, {'light': 'noon'}, 'it must be one of sun, overcast, dusk, night'),
        (Surroundings, {'texture': -0.1}, 'the texture is -0.1'),
    ],
)
def test_it_is_said_what_is_wrong(made: Any, values: dict[str, Any], sentence: str) -> None:
    """In one sentence."""
    with pytest.raises(OpticsError, match=sentence):
        made(**values)


def test_a_range_is_above_zero() -> None:
    """As all else."""
    with pytest.raises(OpticsError, match='the range, m, is 0; it must be above 0'):
        link_budget(Led(1.0), Receiver(), Surroundings(), 0.0)
