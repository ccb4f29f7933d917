"""The clutter scenes leave their target's surroundings alone, and know its SNR."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.clutter import amplitude, clutter, IN_STEP_RATE, LAMPS, with_target
from blob_tracker.simulation import AmbientLight, HotPixels, Light, Scene, Sensor, truth_of
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SILENT = SensorNoise(gain=np.inf, read_noise=0.0)
REACH = 14  # px: 3 sigma of the widest target and two pixels


@pytest.mark.parametrize('name', clutter())
def test_nothing_hides_the_target(name: str) -> None:
    """What stands in the scene adds at most 1 DN of rounding and far tails near the target."""
    scene = replace(clutter()[name].scene, sensor=Sensor(SILENT))
    # Light on the whole picture is no thing in it, and the constant hot pixels are everywhere.
    things = [
        each for each in scene.elements
        if not isinstance(each, AmbientLight)
        and not (isinstance(each, HotPixels) and not each.blinking)
    ]
    cluttered, bare = replace(scene, elements=things), replace(scene, elements=())
    aimed = with_target(clutter()[name].scene, 8.0, 4.0)
    for index in range(0, 600, 7):
        x, y, *_ = aimed.truth(index)
        left, top = round(x) - REACH, round(y) - REACH
        assert left >= 0 and top >= 0
        part = slice(top, top + 2 * REACH + 1), slice(left, left + 2 * REACH + 1)
        added = cluttered.frame(index)[part].astype(int) - bare.frame(index)[part]
        assert np.abs(added).max() <= 1


def test_snr_is_that_of_the_pixel_at_the_peak() -> None:
    """Find it in the frames of a target as wide as many pixels: mean over standard deviation."""
    scene = replace(clutter()['plain'].scene, exposure=0.3, width=160, height=120)
    aimed = with_target(scene, 20.0, 12.0)
    # It stands still, in the middle, where the slope of the wall has its mean brightness.
    assert isinstance(aimed.target, Light)
    light = replace(aimed.target, x=79.5, y=60.0, reach_x=0.0, reach_y=0.0)
    aimed = replace(aimed, target=light)
    lit = np.array([aimed.frame(index)[60, 79] for index in range(0, 4000, 2)], dtype=float)
    # 2000 frames tell a standard deviation to 1.6 %.
    assert (lit.mean() - 40.0) / lit.std() == pytest.approx(20.0, rel=0.05)


def test_amplitude_solves_its_equation() -> None:
    """A = SNR sqrt((A + b) / gain + read_noise^2 + 1/12)."""
    scene = Scene(background=60.0, sensor=Sensor(SensorNoise(gain=10.0, read_noise=2.0)))
    level = amplitude(scene, 8.0)
    noise = np.sqrt((level + 60.0) / 10.0 + 4.0 + 1.0 / 12.0)
    assert level / noise == pytest.approx(8.0, rel=1e-12)


def test_lamps_in_step_are_brighter_in_every_other_frame() -> None:
    """100 Hz at 40 frames a second: the worst that the mains can do."""
    scene = replace(clutter()['lamps in step'].scene, rate=IN_STEP_RATE)
    shots = [scene.shot(index) for index in range(6)]
    levels = [[truth_of(lamp, shot).amplitude for shot in shots] for lamp in LAMPS[:3]]
    for each in levels:
        assert each[::2] == pytest.approx([each[0]] * 3, abs=1e-6)
        assert each[1::2] == pytest.approx([each[1]] * 3, abs=1e-6)
    assert max(abs(each[0] - each[1]) for each in levels) > 0.2
