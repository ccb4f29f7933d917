"""Files of bodies: read in metres, or refused with a reason."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.constellation import Body, BodyError, read_body, write_body
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


def test_what_is_written_is_read(tmp_path: Path) -> None:
    """To a tenth of a micrometre."""
    places = np.random.default_rng(1).normal(size=(3, 3))
    body = Body(('a', 'b', 'c'), places, np.full(3, 1e-4), 0.003)
    write_body(tmp_path / 'body.yaml', body, ['by hand'])
    found = read_body(tmp_path / 'body.yaml')
    assert found.names == body.names
    np.testing.assert_allclose(found.places, body.places, atol=1e-7)
    np.testing.assert_allclose(found.sigmas, body.sigmas, atol=1e-7)
    assert found.size_sigma == 0.003
    assert (tmp_path / 'body.yaml').read_text().startswith('# by hand')


def test_numbers_without_a_point_are_read(tmp_path: Path) -> None:
    """YAML takes 1e-3 for a word."""
    (tmp_path / 'body.yaml').write_text(FILE.replace('0.001', '1e-3').replace('-0.2', '-2e-1'))
    body = read_body(tmp_path / 'body.yaml')
    assert (body.sigmas[0], body.places[2, 0]) == (1e-3, -0.2)


def test_places_in_kilometres_are_named() -> None:
    """As those in millimetres are."""
    with pytest.raises(BodyError, match='and must be 0.002; their positions are in metres'):
        Body(('a', 'b', 'c'), 2e-4 * np.eye(3), np.zeros(3))


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
    ('lights', 'lamps', 'a body file has no lamps; it has sigma, size_sigma and lights'),
    ('sigma: 0.002', 'sigmas: 0.002', 'the light starboard has no sigmas; it has place and'),
    ('place: [0.15, -0.10, 0.0], ', '', 'the light starboard has no place; it must be'),
    ('[-0.2, 0.0, 0.05]', '', 'the light tail has no place; it must be'),
    ('[-0.2, 0.0, 0.05]', '"123"', "the light tail has the place '123'; it must be"),
    ('[-0.2, 0.0, 0.05]', '[a, 0.0, 0.05]', "the place of tail holds 'a', which is not a number"),
    ('[-0.2, 0.0, 0.05]', '[true, 0.0, 0.05]', 'the place of tail holds True, which is not'),
    ('sigma: 0.002', 'sigma: 2mm', "the sigma of starboard holds '2mm', which is not a number"),
    ('sigma: 0.001', 'sigma: 1mm', "sigma holds '1mm', which is not a number"),
    ('  tail', '  on', 'name of a light for True, as it does on, .* put it in quotes'),
    ('place: [', 'at: [', 'the light starboard has no at; it has place and sigma'),
    (FILE[FILE.index('lights'):], '', 'has no lights'),
    ('sigma: 0.001', 'size_sigma: 2.0', 'it must be 0 to 1, of its size'),
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
