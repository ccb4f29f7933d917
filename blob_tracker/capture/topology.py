"""The parts of a camera behind a media controller: which sensor feeds a video device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Node = tuple[int, int]  # major and minor number of a device


@dataclass(frozen=True)
class Topology:
    """
    What `media-ctl -p` prints of a media device.

    Parameters
    ----------
    names : mapping of int to str
        The entities by their number.
    sensors : frozenset of int
        Those that are image sensors.
    videos, subdevices : mapping of int to (int, int)
        The device node of an entity, /dev/videoN or /dev/v4l-subdevN, of those that have one.
    links : tuple of (int, int)
        Entity that pictures come from, and entity that they go to, of the links that are enabled.
    apart : frozenset of int
        Those that no pictures can come to or from, as a lens or a flash: they have no links.

    """

    names: Mapping[int, str]
    sensors: frozenset[int]
    videos: Mapping[int, Node]
    subdevices: Mapping[int, Node]
    links: tuple[tuple[int, int], ...]
    apart: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Sensor:
    """
    The sensor that feeds a video device.

    Parameters
    ----------
    name : str
        Of its entity: imx219 10-0010, say.
    nodes : tuple of (int, int)
        Its subdevice and those between it and the video device, in the order of the light: some
        drivers have the pixel rate on the second of them.

    """

    name: str
    nodes: tuple[Node, ...]


def sensor_of(topology: Topology, video: Node) -> Sensor | None:
    """
    Return the sensor whose pictures come out of a video device.

    Walked are the links that are enabled, against the light. Inside an entity any input may lead
    to any output.

    Parameters
    ----------
    topology : Topology
        Of a media device.
    video : (int, int)
        The video device.

    Returns
    -------
    Sensor or None
        None if the video device is another media device's, no sensor is linked to it, or
        several are: nobody knows which it shows.

    """
    ends = [entity for entity, node in topology.videos.items() if node == video]
    if not ends:
        return None
    way = _reached(ends[0], [(sink, source) for source, sink in topology.links])
    sensors = [entity for entity in way if entity in topology.sensors]
    if len(sensors) != 1:
        return None
    beyond = _reached(sensors[0], list(topology.links))
    chain = [entity for entity in reversed(way) if entity in beyond]
    return Sensor(
        topology.names[sensors[0]],
        tuple(topology.subdevices[entity] for entity in chain if entity in topology.subdevices),
    )


def fed_by(topology: Topology, subdevice: Node) -> tuple[str, list[Node] | None] | None:
    """
    Return the name of a subdevice and the video devices that its pictures go to.

    Parameters
    ----------
    topology : Topology
        Of a media device.
    subdevice : (int, int)
        The subdevice.

    Returns
    -------
    str and list of (int, int) or None, or None
        None for the video devices where no pictures can come from it, as from a lens; None alone
        where it is another media device's.

    """
    begins = [entity for entity, node in topology.subdevices.items() if node == subdevice]
    if not begins:
        return None
    if begins[0] in topology.apart:
        return topology.names[begins[0]], None
    way = _reached(begins[0], list(topology.links))
    return topology.names[begins[0]], [
        topology.videos[entity] for entity in way if entity in topology.videos
    ]


def _reached(start: int, steps: list[tuple[int, int]]) -> list[int]:
    """Return an entity and all that can be reached from it, the nearest first."""
    reached = [start]
    for entity in reached:  # grows meanwhile
        reached += [
            after for before, after in steps if before == entity and after not in reached
        ]
    return reached
