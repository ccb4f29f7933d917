"""Where the lights are on a body, and the file that says so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from blob_tracker.camera.yaml_file import CalibrationError, content_of, write_content
from blob_tracker.constellation.errors import BodyError
from blob_tracker.kernel import Array
import numpy as np
import yaml

LEAST_LIGHTS = 3
MOST_EXTENT_M = 50.0  # a larger file is in millimetres
LEAST_EXTENT_M = 2e-3  # a smaller one is in kilometres, or a size and not places
DIGITS = 7  # of a place, m, that are written
KEYS, OF_LIGHT = ('sigma', 'size_sigma', 'lights'), ('place', 'sigma')
IN_LINE = 0.02  # second singular value of the places over the first


@dataclass(frozen=True)
class Body:
    """
    A rigid body with lights.

    Parameters
    ----------
    names : tuple of str
        Of the lights, each once.
    places : (n, 3) array
        Of the lights in the body's frame, m.
    sigmas : (n,) array
        Standard deviation of each place along each axis, m.
    size_sigma : float
        Standard deviation of the size of the whole, over it: of one length that it is made by.

    Raises
    ------
    BodyError
        If it can have no pose: fewer than three lights, a name twice, lights in one line or at
        one place, or further apart than 50 m or less than 2 mm.

    Examples
    --------
    Three lights, whose places are known to 1 mm:

    >>> places = np.array([[0.15, 0.1, 0.0], [0.15, -0.1, 0.0], [-0.2, 0.0, 0.05]])  # m
    >>> body = Body(('port', 'starboard', 'tail'), places, np.full(3, 0.001))
    >>> dict(zip(body.names, body.places.tolist()))['tail']
    [-0.2, 0.0, 0.05]
    >>> Body(('port', 'starboard'), places[:2], np.full(2, 0.001))
    Traceback (most recent call last):
        ...
    blob_tracker.constellation.errors.BodyError: the body has 2 lights; a pose needs three or more

    """

    names: tuple[str, ...]
    places: Array
    sigmas: Array
    size_sigma: float = 0.0

    def __post_init__(self) -> None:
        count = len(self.names)
        if self.places.shape != (count, 3) or self.sigmas.shape != (count,):
            raise BodyError(
                f'{count} names, places of shape {self.places.shape} and sigmas of shape '
                f'{self.sigmas.shape}; each light has a name, x, y, z and a sigma'
            )
        if count < LEAST_LIGHTS:
            raise BodyError(f'the body has {count} lights; a pose needs three or more')
        twice = sorted({name for name in self.names if self.names.count(name) > 1})
        if twice:
            raise BodyError(f'two lights of the body have the name {", ".join(twice)}')
        if not (np.isfinite(self.places).all() and np.isfinite(self.sigmas).all()):
            raise BodyError('the places of the lights and their sigmas must be finite')
        if not 0.0 <= self.size_sigma < 1.0:
            raise BodyError(
                f'the size_sigma of the body is {self.size_sigma:g}; it must be 0 to 1, of its '
                'size'
            )
        if (self.sigmas < 0.0).any():
            raise BodyError(f'the least sigma is {self.sigmas.min():g} m; it must be 0 or more')
        extent, nearest = _distances(self.places)
        if extent > MOST_EXTENT_M:
            raise BodyError(
                f'the lights of the body are {extent:g} m apart, and may be {MOST_EXTENT_M:g}; '
                'their positions are in metres, not millimetres'
            )
        if 0.0 < extent < LEAST_EXTENT_M:
            raise BodyError(
                f'the lights of the body are {extent:g} m apart, and must be '
                f'{LEAST_EXTENT_M:g}; their positions are in metres'
            )
        if nearest <= 0.0:
            raise BodyError('two lights of the body are at the same place')
        if in_line(self.places):
            raise BodyError(
                'the lights of the body are in one line: its rotation about that line cannot be '
                'seen; put one light beside it'
            )
        if self.sigmas.max() > 0.25 * extent:
            raise BodyError(
                f'the greatest sigma is {self.sigmas.max():g} m on a body of {extent:g} m; both '
                'are in metres'
            )


def in_line(places: Array) -> bool:
    """Tell whether points are in one line as far as a pose is concerned."""
    beside = places - places.mean(axis=0)
    _, middle, greatest = np.linalg.eigvalsh(beside.T @ beside)
    return bool(middle < IN_LINE**2 * greatest)


def read_body(path: str | Path) -> Body:
    """
    Return the body of a file.

    ::

        sigma: 0.001                    # m, of each place along each axis; 0 where it is left out
        size_sigma: 0.003               # of the size of the whole, over it; 0 where it is left out
        lights:
          port: [0.15, 0.10, 0.0]       # m, in the body's frame
          starboard: {place: [0.15, -0.10, 0.0], sigma: 0.002}

    Parameters
    ----------
    path : str or Path
        The YAML file.

    Raises
    ------
    BodyError
        If there is no such file, it is not such YAML, or the body can have no pose.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, 'body.yaml')
    ...     _ = path.write_text('lights: {a: [0.1, 0, 0], b: [0, 0.1, 0], c: [0, 0, 0.1]}')
    ...     print(read_body(path).places.tolist())  # m
    [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]

    """
    try:
        with content_of(path, 'body file') as content:
            _check_names(path)
            _check_keys('a body file', content, KEYS)
            sigma = _number('sigma', content.get('sigma', 0.0))
            size_sigma = _number('size_sigma', content.get('size_sigma', 0.0))
            lights = content['lights']
            if not isinstance(lights, dict):
                raise TypeError('lights must be names, each with its [x, y, z] in m')
            entries = [_entry(name, each, sigma) for name, each in lights.items()]
    except CalibrationError as error:
        raise BodyError(str(error)) from None
    try:
        return Body(
            tuple(map(str, lights)),
            np.array([place for place, _ in entries]).reshape(-1, 3),
            np.array([each for _, each in entries]),
            size_sigma,
        )
    except BodyError as error:
        raise BodyError(f'{path}: {error}') from None


def write_body(path: str | Path, body: Body, comments: Sequence[str] = ()) -> None:
    """
    Write a file that `read_body` reads.

    Parameters
    ----------
    path : str or Path
        The YAML file.
    body : Body
        Its lights, to 0.1 um.
    comments : sequence of str
        Lines put on top.

    Raises
    ------
    CalibrationError
        If writing there fails.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> places = np.array([[0.15, 0.1, 0.0], [0.15, -0.1, 0.0], [-0.2, 0.0, 0.05]])  # m
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, 'body.yaml')
    ...     write_body(path, Body(('port', 'starboard', 'tail'), places, np.zeros(3)), ['glider'])
    ...     print(path.read_text().splitlines()[0])
    ...     print(read_body(path).names)
    # glider
    ('port', 'starboard', 'tail')

    """
    lights = {
        name: {'place': [round(each, DIGITS) for each in place], 'sigma': round(sigma, DIGITS)}
        for name, place, sigma in zip(
            body.names, body.places.tolist(), body.sigmas.tolist(), strict=True)
    }
    write_content(
        path, 'body file', {'size_sigma': round(body.size_sigma, DIGITS), 'lights': lights},
        comments,
    )


def _entry(name: Any, entry: Any, sigma: float) -> tuple[list[float], float]:
    """Return the place of a light and its sigma, m."""
    if name is None or isinstance(name, bool):
        raise CalibrationError(
            f'YAML takes the name of a light for {name}, as it does on, off, yes, no and null: '
            'put it in quotes'
        )
    own = entry if isinstance(entry, dict) else {'place': entry}
    _check_keys(f'the light {name}', own, OF_LIGHT)
    place = own.get('place')
    if not isinstance(place, list):
        raise CalibrationError(
            f'the light {name} has {"no place" if place is None else f"the place {place!r:.40}"}; '
            'it must be [x, y, z] in m'
        )
    if len(place) != 3:
        raise CalibrationError(f'the place of {name} has {len(place)} numbers, not 3')
    return (
        [_number(f'the place of {name}', each) for each in place],
        _number(f'the sigma of {name}', own.get('sigma', sigma)),
    )


def _number(what: str, value: Any) -> float:
    """Return a number; YAML takes 1e-3, which has no point, for a word."""
    try:
        if isinstance(value, bool):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise CalibrationError(f'{what} holds {value!r:.40}, which is not a number') from None


def _check_keys(what: str, content: dict[str, Any], keys: tuple[str, ...]) -> None:
    """Refuse a key that says nothing: it is a misspelt one."""
    unknown = sorted(str(key) for key in content if key not in keys)
    if unknown:
        raise CalibrationError(
            f'{what} has no {", ".join(unknown)}; it has {", ".join(keys[:-1])} and {keys[-1]}'
        )


def _check_names(path: str | Path) -> None:
    """Refuse a name that is there twice, of which YAML would keep the last."""
    for key, value in yaml.compose(Path(path).read_text(encoding='utf-8')).value:
        if key.value == 'lights' and isinstance(value, yaml.MappingNode):
            names = [name.value for name, _ in value.value]
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise CalibrationError(f'two lights of the body have the name {", ".join(twice)}')


def _distances(places: Array) -> tuple[float, float]:
    """Return the greatest and the least distance of two lights, m."""
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    return float(apart.max()), float(apart[np.triu_indices(len(places), 1)].min())
