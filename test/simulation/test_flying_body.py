"""A body with lights in flight: each is imaged where its pose puts it."""

from __future__ import annotations

from blob_tracker.camera import pinhole_matrix
from blob_tracker.constellation import read_body
from blob_tracker.resources import config_path
from blob_tracker.simulation import blinking_lights, waveforms_of
from blob_tracker.simulation.flying_body import Flight, flying_body
import numpy as np

MATRIX = pinhole_matrix(600.0, 640, 480)


def test_lights_are_where_the_pose_puts_them() -> None:
    """Of the demo's drone: all within the picture, never one on another, and drawn there."""
    body = read_body(config_path('drone.yaml'))
    places = dict(zip(body.names, body.places))
    codes = {name: '1' * (index + 5) + '00' for index, name in enumerate(body.names)}
    scene, alone = blinking_lights(waveforms_of('coded', codes=codes), texture=0.0)
    scene, lights, flight = flying_body(scene, alone, places, MATRIX)
    assert tuple(lights) == body.names
    for time in np.arange(0.0, flight.period, 0.1).tolist():
        rotation, position = flight.pose(time)
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) > 0.0
        spots = np.array([light.spot(time)[:2] for light in lights.values()])
        points = (body.places @ rotation.T + position) @ MATRIX.T
        np.testing.assert_allclose(spots, points[:, :2] / points[:, 2:], atol=1e-9)
        assert (np.abs(spots - [319.5, 239.5]) < [300.0, 220.0]).all()
        apart = np.linalg.norm(spots[:, None] - spots, axis=2) + 1e3 * np.eye(len(spots))
        assert apart.min() > 8.0  # px: four widths of a light
    picture = scene.frame(3)
    lit = [each for each in lights.values() if each.waveform(np.array([3.0 / 60.0]))[0]]
    x, y = lit[0].spot(3.0 / 60.0)[:2]
    assert picture[round(y), round(x)] > 2 * np.median(picture)


def test_a_flight_is_smooth_and_comes_back() -> None:
    """No faster than the demo tells the node: 0.5 m/s and 0.6 rad/s along and about each axis."""
    flight = Flight(9.0)
    step = 1e-4
    for time in np.arange(0.0, 9.0, 0.05).tolist():
        (one, place), (other, later) = flight.pose(time), flight.pose(time + step)
        turned = (other @ one.T - one @ other.T) / 2.0 / step
        assert np.abs(later - place).max() / step < 0.5
        assert np.abs(turned).max() < 1.2
    for one, other in zip(flight.pose(0.0), flight.pose(9.0)):
        np.testing.assert_allclose(one, other, atol=1e-9)
