"""
The kernel's media controller interface: which parts a camera has, and how they are linked.

Layouts and meanings follow the kernel's "Media subsystem" documentation, Part IV (Media
Controller API).
"""

from __future__ import annotations

import ctypes
from ctypes import c_char, c_uint32, c_uint64

from blob_tracker.capture import videodev2
from blob_tracker.capture.topology import Topology

_CAM_SENSOR = 0x00020001  # media_v2_entity.function
_V4L_VIDEO, _V4L_SUBDEV = 0x00000200, 0x00000203  # media_v2_interface.intf_type
_LINK_ENABLED = 0x00000001
_LINK_TYPE, _INTERFACE_LINK = 0xf0000000, 0x10000000


class Entity(ctypes.Structure):
    """media_v2_entity."""

    _pack_ = 1
    _fields_ = [
        ('id', c_uint32),
        ('name', c_char * 64),
        ('function', c_uint32),
        ('flags', c_uint32),
        ('reserved', c_uint32 * 5),
    ]


class Interface(ctypes.Structure):
    """media_v2_interface with the device node of its union."""

    _pack_ = 1
    _fields_ = [
        ('id', c_uint32),
        ('intf_type', c_uint32),
        ('flags', c_uint32),
        ('reserved', c_uint32 * 9),
        ('major', c_uint32),
        ('minor', c_uint32),
        ('_union', c_uint32 * 14),
    ]


class Pad(ctypes.Structure):
    """media_v2_pad."""

    _pack_ = 1
    _fields_ = [
        ('id', c_uint32),
        ('entity_id', c_uint32),
        ('flags', c_uint32),
        ('index', c_uint32),
        ('reserved', c_uint32 * 4),
    ]


class Link(ctypes.Structure):
    """media_v2_link."""

    _pack_ = 1
    _fields_ = [
        ('id', c_uint32),
        ('source_id', c_uint32),
        ('sink_id', c_uint32),
        ('flags', c_uint32),
        ('reserved', c_uint32 * 6),
    ]


class V2Topology(ctypes.Structure):
    """media_v2_topology."""

    _pack_ = 1
    _fields_ = [
        ('topology_version', c_uint64),
        ('num_entities', c_uint32),
        ('reserved1', c_uint32),
        ('ptr_entities', c_uint64),
        ('num_interfaces', c_uint32),
        ('reserved2', c_uint32),
        ('ptr_interfaces', c_uint64),
        ('num_pads', c_uint32),
        ('reserved3', c_uint32),
        ('ptr_pads', c_uint64),
        ('num_links', c_uint32),
        ('reserved4', c_uint32),
        ('ptr_links', c_uint64),
    ]


# _IOWR('|', 4, struct media_v2_topology)
G_TOPOLOGY = 3 << 30 | ctypes.sizeof(V2Topology) << 16 | ord('|') << 8 | 4


def read_topology(fd: int) -> Topology:
    """
    Return the parts of an open media device and their links.

    Raises
    ------
    OSError
        ENOTTY where it is none, or of a kernel before 4.5.

    """
    counted = V2Topology()
    videodev2.ioctl(fd, G_TOPOLOGY, counted)
    entities = (Entity * counted.num_entities)()
    interfaces = (Interface * counted.num_interfaces)()
    pads = (Pad * counted.num_pads)()
    links = (Link * counted.num_links)()
    counted.ptr_entities = ctypes.addressof(entities)
    counted.ptr_interfaces = ctypes.addressof(interfaces)
    counted.ptr_pads = ctypes.addressof(pads)
    counted.ptr_links = ctypes.addressof(links)
    videodev2.ioctl(fd, G_TOPOLOGY, counted)
    entity_of = {pad.id: pad.entity_id for pad in pads}
    nodes = {each.id: each for each in interfaces}
    owned = [
        (nodes[link.source_id], link.sink_id) for link in links
        if link.flags & _LINK_TYPE == _INTERFACE_LINK and link.source_id in nodes
    ]
    data_links = [
        (entity_of[link.source_id], entity_of[link.sink_id], link.flags) for link in links
        if not link.flags & _LINK_TYPE
        and link.source_id in entity_of and link.sink_id in entity_of
    ]
    return Topology(
        names={each.id: each.name.decode(errors='replace') for each in entities},
        sensors=frozenset(each.id for each in entities if each.function == _CAM_SENSOR),
        videos={
            entity: (node.major, node.minor) for node, entity in owned
            if node.intf_type == _V4L_VIDEO
        },
        subdevices={
            entity: (node.major, node.minor) for node, entity in owned
            if node.intf_type == _V4L_SUBDEV
        },
        links=tuple(
            (source, sink) for source, sink, flags in data_links if flags & _LINK_ENABLED
        ),
        apart=frozenset(each.id for each in entities) - {
            entity for source, sink, _ in data_links for entity in (source, sink)
        },
    )
