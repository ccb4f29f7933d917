"""Rays of lights for a calibration: of a bag, of a table that `track` wrote, or live."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import csv
from math import isfinite
from pathlib import Path
import re

from blob_tracker.calibration.rays import Rays
from blob_tracker.commands.sources import SourceError
from blob_tracker.ros.bags import Bag, opened, RecordingError
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np

KIND = 'geometry_msgs/msg/PoseWithCovarianceStamped'
RAY = re.compile(r'(?:.*/)?target/([^/]+)/ray')
COLUMNS = (
    'stamp_s', 'light', 'azimuth_mrad', 'elevation_mrad', 'sigma_azimuth_mrad',
    'sigma_elevation_mrad', 'covariance_mrad2',
)


def recorded_bearings(bag: Bag, topics: Sequence[str]) -> dict[str, tuple[list[Bearing], str]]:
    """
    Return the bearings of each of some topics of rays, and the frame that they are in.

    Raises
    ------
    RecordingError
        If the bag lacks one of them, it holds an invalid ray, or all rays have one stamp.

    """
    there = {
        topic.name: topic for topic in bag.topics if topic.name in topics and topic.kind == KIND
    }
    missing = [name for name in topics if name not in there or not bag.topics[there[name]]]
    if missing:
        words = ', '.join(topic.name for topic in bag.topics if topic.kind == KIND) or 'none'
        raise RecordingError(
            f'{bag.path} has no rays on {", ".join(missing)}; of that type it has: {words}'
        )
    came: dict[str, list[Bearing]] = {name: [] for name in topics}
    frames = dict.fromkeys(topics, '')
    for message in bag.messages(list(there.values())):
        ray = bag.decoded(message)
        try:
            came[message.topic.name].append(to_bearing(ray))
        except MessageError as error:
            raise RecordingError(f'{bag.path}, {message.topic.name}: {error}') from None
        frames[message.topic.name] = str(ray.header.frame_id)
    _check_stamps(came, bag.path)
    return {name: (came[name], frames[name]) for name in topics}


def rays_of(series: Sequence[Sequence[Bearing]]) -> list[Rays]:
    """Return series of bearings that are valid, each in the order of their stamps, each once."""
    first_ns = min((each.stamp_ns for came in series for each in came), default=0)
    return [_rays(came, first_ns) for came in series]


def _rays(came: Sequence[Bearing], first_ns: int) -> Rays:
    in_order = {each.stamp_ns: each for each in sorted(came, key=lambda each: each.stamp_ns)}
    times = np.array([1e-9 * (stamp_ns - first_ns) for stamp_ns in in_order])
    angles = MRAD * np.array(
        [(each.azimuth, each.elevation) for each in in_order.values()]
    ).reshape(-1, 2)
    covariance = MRAD**2 * np.array(
        [each.covariance for each in in_order.values()]
    ).reshape(-1, 2, 2)
    valid = np.asarray(
        np.isfinite(np.column_stack([angles, covariance.reshape(-1, 4)])).all(axis=1)
    )
    valid[valid] = np.linalg.eigvalsh(covariance[valid])[:, 0] > 0.0
    return Rays(times, angles, covariance).part(valid)


def lights_seen(
    source: Path | None, lights: Sequence[str], namespace: str, seconds: float
) -> dict[str, list[Bearing]]:
    """
    Return the bearings of each light of a bag or of a table of `track`, or live.

    Parameters
    ----------
    source : Path, optional
        The bag or the table; if it is left out the topics are listened to.
    lights : sequence of str
        That are wanted; none: all that there are.
    namespace : str
        Of the camera's topics.
    seconds : float
        To listen.

    Raises
    ------
    RecordingError
        If it is unreadable, or lacks a light.
    SourceError
        If live topics need ROS, which is missing.

    """
    if source is not None and source.suffix == '.csv':
        return _wanted(_table(source), lights, source)
    if source is None:
        try:
            from blob_tracker.ros.endpoints.live_rays import live_rays
        except ImportError:
            raise SourceError('live topics need ROS: source its setup file') from None
        came = live_rays({name: _topic(namespace, name) for name in lights}, seconds)
        _check_stamps(came, 'the topics')
        return came
    with opened(source) as bag:
        topics = {_topic(namespace, name): name for name in lights}
        if not topics:
            for topic in bag.topics:
                light = RAY.fullmatch(topic.name)
                if light and topic.kind == KIND and topic.name == _topic(namespace, light[1]):
                    topics[topic.name] = light[1]
        if not topics:
            there = ', '.join(
                topic.name for topic in bag.topics if topic.kind == KIND) or 'none'
            raise RecordingError(
                f'{source} has no rays on {_topic(namespace, "NAME")}; of that type it has: '
                f'{there} (--camera is the namespace before target)'
            )
        found = recorded_bearings(bag, list(topics))
    return {topics[name]: bearings for name, (bearings, _) in found.items()}


def _topic(namespace: str, light: str) -> str:
    """Return the topic of a camera's rays to a light."""
    return '/'.join(['', *filter(None, [namespace.strip('/')]), 'target', light, 'ray'])


def _wanted(
    found: Mapping[str, list[Bearing]], lights: Sequence[str], source: Path
) -> dict[str, list[Bearing]]:
    missing = [name for name in lights if name not in found]
    if missing:
        raise RecordingError(
            f'{source} has no light {", ".join(missing)}; it has {", ".join(found) or "none"}'
        )
    return {name: found[name] for name in lights or found}


def _table(path: Path) -> dict[str, list[Bearing]]:
    """Return the bearings of each light of a table that `track` wrote."""
    found: dict[str, list[Bearing]] = {}
    try:
        with path.open(newline='', encoding='utf-8-sig') as file:
            rows = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (rows.fieldnames or ())]
            if missing:
                raise RecordingError(
                    f'{path} has no column {", ".join(missing)}: it must be a table as '
                    '`python3 -m blob_tracker track` writes it'
                )
            for row in rows:
                if row['azimuth_mrad'] and row['light']:
                    found.setdefault(row['light'], []).append(_bearing(row))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else 'it is no text'
        raise RecordingError(f'cannot read the table {path}: {reason}') from None
    except (TypeError, ValueError) as error:
        raise RecordingError(f'{path}, line {rows.line_num}: {error}') from None
    if not found:
        raise RecordingError(f'{path} has no bearing of a light that has a name: see flash.codes')
    _check_stamps(found, path)
    return found


def _check_stamps(found: Mapping[str, list[Bearing]], source: Path | str) -> None:
    """Refuse rays that all have one stamp, of which only one would count."""
    for name, bearings in found.items():
        stamps = {each.stamp_ns for each in bearings}
        if len(bearings) > 1 and len(stamps) == 1:
            raise RecordingError(
                f'{source}: all {len(bearings)} rays of {name} have one stamp, '
                f'{1e-9 * stamps.pop():.3f} s; does the driver of the camera set none?'
            )


def _bearing(row: Mapping[str, str]) -> Bearing:
    seconds, _, fraction = row['stamp_s'].partition('.')
    stamp_ns = int(seconds) * 10**9 + int(f'{fraction:0<9}'[:9])
    numbers = [float(row[name]) for name in COLUMNS[2:]]
    if not all(map(isfinite, numbers)):
        raise ValueError('a number is not finite')
    azimuth, elevation, across, up, both = numbers
    covariance = np.array([[across**2, both], [both, up**2]])
    return Bearing(azimuth, elevation, covariance, stamp_ns)
