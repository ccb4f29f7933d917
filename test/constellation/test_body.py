"""Files of bodies: read in metres, or refused with a reason."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.constellation import BodyError, read_body
import numpy as np
import pytest

FILE = """\
sigma: 0.001
lights:
  port: [0.15, 0.10, 0.0]
  starboard: {place: [0.15, -0.10, 0.0], sigma: 0.002}
  tail: [-0.2, 0.0, 0.05]
"""


def test_a_file_is_read(tmp_path: Path) -> None:
    """A light may have a sigma of its own."""
    path = tmp_path / 'body.yaml'
    path.write_text(FILE)
    body = read_body(path)
    assert body.names == ('port', 'starboard', 'tail')
    np.testing.assert_array_equal(body.places[1], [0.15, -0.10, 0.0])
    np.testing.assert_array_equal(body.sigmas, [0.001, 0.002, 0.001])


@pytest.mark.parametrize(('old', 'new', 'reason'), [
    ('[-0.2, 0.0, 0.05]', '[-200.0, 0.0, 50.0]', 'are in metres, not millimetres'),
    ('[-0.2, 0.0, 0.05]', '[0.15, 0.0, 0.0]', 'are in one line'),
    ('[-0.2, 0.0, 0.05]', '[0.15, 0.10, 0.0]', 'are at the same place'),
    ('[-0.2, 0.0, 0.05]', '[-0.2, 0.0]', 'the place of tail has 2 numbers'),
    ('[-0.2, 0.0, 0.05]', '[-0.2, 0.0, .nan]', 'must be finite'),
    ('tail', 'port', 'two lights of the body have the name port'),
    ('  tail: [-0.2, 0.0, 0.05]', '', 'has 2 lights; a pose needs three'),
    ('sigma: 0.001', 'sigma: 1.0', 'the greatest sigma is 1 m on a body of'),
    ('sigma: 0.001', 'sigma: -1.0', 'must be 0 or more'),
    ('lights', 'lamps', 'has no lights'),
    (FILE, '[', 'is not YAML'),
])
def test_what_can_be_no_body_is_named(tmp_path: Path, old: str, new: str, reason: str) -> None:
    """With the name of the file."""
    path = tmp_path / 'body.yaml'
    path.write_text(FILE.replace(old, new, 1))
    with pytest.raises(BodyError, match=reason) as caught:
        read_body(path)
    assert 'body.yaml' in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    """As any other."""
    with pytest.raises(BodyError, match='cannot read the body file'):
        read_body(tmp_path / 'none.yaml')
