"""Bearings of an analogue camera's fields, from its pictures to angles, with their jitter."""

from __future__ import annotations

import math

from blob_tracker.calibration.line_jitter import measure_line_jitter
from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.capture.fields import fields
from blob_tracker.pipeline import Pipeline
from blob_tracker.simulation import InterlacedCamera, Light, periodic, Scene, Sensor
from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.simulation.line_jitter import draw_edge, jittering_offsets
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray
import pytest
from support.flashes import nees

NOISE = SensorNoise(10.0, 1.0)
WIDTH, HEIGHT, RATE = 128, 480, 50.0  # px, fields/s
PICTURES = 40
CHAIN = AnalogueChain(drift=1.0, between_fields=0.2, per_line=0.05)
MODEL = CameraModel(WIDTH, HEIGHT, pinhole_matrix(600.0, WIDTH, HEIGHT))
IN_STEP = periodic(RATE / 4.0, 0.5, 0.125)  # with the pictures: on in both fields of every other


@pytest.fixture(scope='module')
def jitter() -> LineJitter:
    """Return what is measured with an edge before a camera that trembles from field to field."""
    random = np.random.default_rng(1)
    pictures = []
    for _ in range(20):
        places = 60.0 + 0.01 * np.arange(HEIGHT) + jittering_offsets(
            CHAIN.offsets(), random, per_line=CHAIN.per_line)
        for kind in range(2):
            places[kind::2] += 0.1 * random.standard_normal()
        mean = draw_edge((HEIGHT, WIDTH), places, 1.1, 30.0, 200.0)
        pictures.append(Sensor(NOISE).expose(mean, random))
    return measure_line_jitter(pictures).jitter


def errors(
    order: str, reach: float, jitter: LineJitter | None
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int_]]:
    """Return errors of the bearings in px, their covariances, and the field of each."""
    light = Light(63.3, 60.2, 1.5, 150.0, IN_STEP, reach_x=reach, reach_y=reach, period=9.0)
    camera = InterlacedCamera(
        Scene(light, width=WIDTH, height=HEIGHT, rate=RATE, exposure=0.05, sensor=Sensor(NOISE)),
        order, CHAIN)
    pipeline = Pipeline(MODEL, noise=NOISE, line_jitter=jitter)
    # Jitter is known up to a straight line over the picture.
    line = np.zeros(2)
    if jitter is not None:
        line = np.polyfit(np.arange(HEIGHT), CHAIN.offsets(), 1)
    stamps, kinds, found, covariances = [], [], [], []
    for index in range(PICTURES):
        for field in fields(camera.picture(index), order, camera.interval_ns):
            for bearing in pipeline.run([field]):
                truth = light.spot((bearing.stamp_ns - 1e9) / 1e9)
                x, y, by_angles = MODEL.place(bearing.azimuth, bearing.elevation)
                found.append([x - truth.x - np.polyval(line, y), y - truth.y])
                covariances.append(by_angles @ bearing.covariance @ by_angles.T)
                stamps.append(bearing.stamp_ns)
                kinds.append(field.y0)
    # Both fields of a lit picture, half of it apart.
    assert set(np.diff(stamps)) == {camera.interval_ns // 2, camera.interval_ns * 3 // 2}
    return np.array(found), np.array(covariances), np.array(kinds)


@pytest.mark.parametrize('order', ['interlaced_tb', 'interlaced_bt'])
def test_a_moving_light_is_where_the_fields_say(jitter: LineJitter, order: str) -> None:
    """Within the covariance, once the jitter of its field's lines is taken off."""
    found, covariances, kinds = errors(order, 30.0, jitter)
    assert len(found) >= PICTURES - 4 and set(kinds) == {0, 1}
    # The mean of N of chi-square with two degrees of freedom, four standard deviations of it.
    assert nees(found, covariances) == pytest.approx(2.0, abs=8.0 / math.sqrt(len(found)))
    for kind in range(2):  # half a line would be 0.5
        of_kind = found[kinds == kind]
        sigma = np.sqrt(covariances[:, 1, 1].mean() / len(of_kind))
        assert abs(of_kind[:, 1].mean()) < 4.0 * sigma


def test_a_still_light_is_at_one_place_in_both_fields(jitter: LineJitter) -> None:
    """To the distance of the fields that the calibration knows; without it they are apart."""
    found, covariances, kinds = errors('interlaced_tb', 0.0, jitter)
    # Jitter that looks like texture to the fit is counted twice: the covariance is wide.
    assert 0.5 < nees(found, covariances) < 2.0 + 8.0 / math.sqrt(len(found))
    apart = found[kinds == 1].mean(axis=0) - found[kinds == 0].mean(axis=0)
    sigma = np.sqrt(4.0 * covariances[:, 1, 1].mean() / len(found))
    assert abs(apart[1]) < 4.0 * sigma
    assert abs(apart[0]) < 4.0 * math.hypot(sigma, jitter.sigma_between_fields)
    raw, covariances, kinds = errors('interlaced_tb', 0.0, None)
    apart = raw[kinds == 1].mean(axis=0) - raw[kinds == 0].mean(axis=0)
    assert apart[0] == pytest.approx(CHAIN.between_fields, abs=4.0 * sigma)
    assert nees(raw, covariances) > 4.0
