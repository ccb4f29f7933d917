"""What the locator makes of pulse_url: a pulse, or why the Gaussian goes on."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.pulse_file import PulseFile
from blob_tracker.location import EffectivePsf, Learned
from blob_tracker.nodes.locator import _pulse
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

METHOD = 'maximum_likelihood'


@pytest.fixture
def written(tmp_path: Path) -> Path:
    """Return a file with a pulse of a camera of 320 x 240 px."""
    bell = np.exp(-0.5 * (np.arange(-6, 7) / 3.0) ** 2)
    pulse = EffectivePsf(np.outer(bell, bell) * 1.1, 0.5, 1.5)
    learned = Learned(pulse, 300, 0.02, 1.0, 1.0, SensorNoise(10.0, 1.0))
    PulseFile(learned, 320, 240, '850 nm').to_yaml(tmp_path / 'pulse.yaml')
    return tmp_path / 'pulse.yaml'


def test_a_file_is_a_pulse(written: Path) -> None:
    """By path or URL; an empty parameter is none, and no fault."""
    for url in (str(written), f'file://{written}'):
        pulse, reason = _pulse(url, METHOD)
        assert pulse is not None and not reason
    assert _pulse('', METHOD) == (None, '')


@pytest.mark.parametrize(
    ('url', 'method', 'sentence'),
    [
        ('/no.yaml', METHOD, 'cannot read the learned pulse /no.yaml'),
        ('http://x/y', METHOD, 'http://x/y: write'),
        (None, 'centroid', "the method 'centroid' takes no learned pulse"),
    ],
)
def test_what_cannot_be_used_is_a_sentence(
    written: Path, url: str | None, method: str, sentence: str
) -> None:
    """The node goes on without it."""
    pulse, reason = _pulse(url or str(written), method)
    assert pulse is None
    assert sentence in reason
