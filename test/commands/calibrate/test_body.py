"""`calibrate body` from end to end: a bag or a table to a body file that poses are made of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from blob_tracker.__main__ import main
from blob_tracker.commands.track.table import COLUMNS
from blob_tracker.constellation import poses, read_body
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.simulation.turned_body import TurnedBody
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from support.bags import START_NS, TYPES

PLACES = {
    'port': [0.2, 0.15, 0.0], 'starboard': [0.2, -0.15, 0.02], 'left': [-0.25, 0.1, 0.1],
    'mast': [0.0, 0.0, 0.2],
}
KIND = 'geometry_msgs/msg/PoseWithCovarianceStamped'
WIDTH = float(np.linalg.norm(np.subtract(PLACES['port'], PLACES['starboard'])))


def bearings(at_once: bool = False) -> dict[str, list[Bearing]]:
    """Return what a camera sees of the body that is turned."""
    body = TurnedBody(np.array(list(PLACES.values())))
    found = body.seen(np.random.default_rng(8), seconds=8.0, at_once=at_once)
    return {
        name: [
            Bearing(across / MRAD, up / MRAD, covariance / MRAD**2, START_NS + round(1e9 * time))
            for time, (across, up), covariance in zip(*series, strict=True)
        ] for name, series in zip(PLACES, found, strict=True)
    }


def recorded(folder: Path, namespace: str = '', stamp_ns: int | None = None) -> Path:
    """Write a bag of it, all of one stamp where it is given; return it."""
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for name, series in bearings().items():
            topic = f'{namespace}/target/{name}/ray'
            connection = writer.add_connection(topic, KIND, typestore=TYPES)
            for each in series:
                message = ray_message(
                    each if stamp_ns is None else replace(each, stamp_ns=stamp_ns), 'optical')
                data = serialize_message(message)
                writer.write(connection, each.stamp_ns, data)
    return folder


def tabled(path: Path) -> Path:
    """Write it as `track` does; return it."""
    rows = [','.join(COLUMNS)]
    for name, series in bearings().items():
        for each in series:
            sigmas = np.sqrt(each.covariance.diagonal()).tolist()
            numbers = (each.azimuth, each.elevation, *sigmas, each.covariance[0, 1])
            seconds, rest = divmod(each.stamp_ns, 10**9)
            words = ['0', f'{seconds}.{rest:09d}', name, *map(str, numbers)]
            rows.append(','.join(words + [''] * (len(COLUMNS) - len(words))))
    rows.append(f'1,{seconds}.0,mast' + ',' * (len(COLUMNS) - 3))  # a frame without it
    path.write_text('\n'.join(rows) + '\n')
    return path


def run(*words: object) -> int:
    """Run the command."""
    return main(['calibrate', 'body', *map(str, words)])


def test_a_bag_becomes_the_file_of_the_constellation(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Poses of the body follow from it, and the picture is there."""
    out = tmp_path / 'drone.yaml'
    bag = recorded(tmp_path / 'bag', '/left')
    assert run(
        bag, '--camera', 'left', '--distance', 'port', 'starboard', WIDTH, '--out', out) == 0
    body = read_body(out)
    assert body.names == tuple(PLACES)
    true = np.array(list(PLACES.values()))
    apart, expected = (
        np.linalg.norm(places[:, None] - places, axis=2) for places in (body.places, true))
    # 1 mm of 0.3 m, the tape's sigma, is 0.3 % of each distance; given here to the digit.
    np.testing.assert_allclose(apart, expected, atol=3e-4)
    assert 0.0 < body.sigmas.max() < 2e-3
    seen = [(name, series[50]) for name, series in bearings(at_once=True).items()]
    found = poses(body, seen)
    assert len(found) == 1
    assert found[0].position[2] == pytest.approx(2.0, abs=0.4)
    assert out.read_text().startswith('# python3 -m blob_tracker calibrate body')
    assert out.with_suffix('.png').read_bytes().startswith(b'\x89PNG')
    assert 'origin port, x to starboard' in capsys.readouterr().out


def test_a_table_of_track_and_no_distance(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The picture is drawn, no file is written, and the exit code tells."""
    out = tmp_path / 'body.yaml'
    assert run(tabled(tmp_path / 'track.csv'), '--out', out) == 1
    assert not out.exists()
    assert out.with_suffix('.png').exists()
    assert 'give --distance' in capsys.readouterr().err
    assert run(tmp_path / 'track.csv', '--lights', 'port', 'lamp', '--out', out) == 1
    assert 'has no light lamp; it has port, starboard, left, mast' in capsys.readouterr().err
    assert run(tmp_path / 'none.csv', '--out', out) == 1
    assert 'none.csv: No such file or directory\n' in capsys.readouterr().err
    (tmp_path / 'other.csv').write_bytes(b'\xff\xfe')
    assert run(tmp_path / 'other.csv', '--out', out) == 1
    assert 'other.csv: it is no text\n' in capsys.readouterr().err
    (tmp_path / 'other.csv').write_text('a,b\n1,2\n')
    assert run(tmp_path / 'other.csv', '--out', out) == 1
    assert 'it must be a table as `python3 -m blob_tracker track`' in capsys.readouterr().err


def test_rays_that_tell_nothing_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Those of a camera in a namespace, those of one stamp, and those without names."""
    out = '--out', tmp_path / 'body.yaml'
    assert run(recorded(tmp_path / 'left', '/left'), *out) == 1
    error = capsys.readouterr().err
    assert 'has no rays on /target/NAME/ray; of that type it has: /left/target/port/ray' in error
    assert '--camera' in error
    assert run(recorded(tmp_path / 'still', stamp_ns=START_NS), *out) == 1
    assert 'rays of /target/port/ray have one stamp' in capsys.readouterr().err
    table = tmp_path / 'track.csv'
    table.write_text(','.join(COLUMNS) + '\n')
    assert run(table, *out) == 1
    assert 'has no bearing of a light that has a name' in capsys.readouterr().err


def test_a_body_that_is_refused_is_not_announced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Places of a distance in mm: the lights are 300 m apart."""
    out = tmp_path / 'body.yaml'
    bag = recorded(tmp_path / 'bag')
    assert run(bag, '--distance', 'port', 'starboard', 1e3 * WIDTH, '--out', out) == 1
    captured = capsys.readouterr()
    assert 'give it in metres, not millimetres' in captured.err
    assert 'body.yaml' not in captured.out
    assert not out.exists()


def test_millimetres_are_refused_before_the_body_is_turned(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No body that somebody turns has lights 10 m apart."""
    assert run(tmp_path / 'none', '--distance', 'port', 'mast', '10') == 1
    assert 'the distance is 10 m, on a body that is turned' in capsys.readouterr().err


@pytest.mark.parametrize('words, sentence', [
    (('bag', '--distance', 'port', 'mast'), 'LIGHT LIGHT M'),
    ((), 'give SOURCE, or with --lights'),
    (('bag', '--lights', 'a/b'), 'is not a name for a light'),
    (('bag', '--seconds', '0'), 'it must be 1 to 3600'),
])
def test_options_that_are_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], sentence: str
) -> None:
    """They are refused before anything is read."""
    assert run(*words, '--out', tmp_path / 'body.yaml') == 2
    assert sentence in capsys.readouterr().err
