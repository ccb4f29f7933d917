"""The layouts of the media controller, against <linux/media.h>, and what is made of an answer."""

from __future__ import annotations

import ctypes
from typing import Any

from blob_tracker.capture import media, videodev2
import pytest


@pytest.mark.parametrize(('struct', 'size'), [
    (media.Entity, 96), (media.Interface, 112), (media.Pad, 32), (media.Link, 40),
    (media.V2Topology, 72),
])
def test_struct_size(struct, size):
    assert ctypes.sizeof(struct) == size


def test_ioctl_number():
    assert media.G_TOPOLOGY == 0xc0487c04


def test_an_answer_of_the_kernel(monkeypatch):
    # imx219 -> unicam-image, with one link that is off, and their device nodes.
    entities = [(1, b'imx219 10-0010', 0x20001), (4, b'unicam-image', 0x10001), (9, b'spare', 0),
                (12, b'lens', 0x20003)]
    interfaces = [(20, 0x203, 81, 7), (21, 0x200, 81, 0), (22, 0x201, 81, 5)]
    pads = [(2, 1), (5, 4), (10, 9)]
    links = [
        (2, 5, 0x3), (10, 5, 0x0),  # pads
        (20, 1, 0x10000003), (21, 4, 0x10000003), (22, 9, 0x10000003),  # nodes
        (1, 12, 0x20000001),  # a lens that belongs to a sensor
    ]
    asked = []

    def kernel(fd: int, number: int, argument: Any) -> None:
        assert (fd, number) == (3, media.G_TOPOLOGY)
        asked.append(argument.ptr_entities)
        argument.num_entities, argument.num_interfaces = len(entities), len(interfaces)
        argument.num_pads, argument.num_links = len(pads), len(links)
        if not argument.ptr_entities:
            return
        for struct, place, rows, names in (
            (media.Entity, argument.ptr_entities, entities, ('id', 'name', 'function')),
            (media.Interface, argument.ptr_interfaces, interfaces,
             ('id', 'intf_type', 'major', 'minor')),
            (media.Pad, argument.ptr_pads, pads, ('id', 'entity_id')),
            (media.Link, argument.ptr_links, links, ('source_id', 'sink_id', 'flags')),
        ):
            for each, row in zip((struct * len(rows)).from_address(place), rows):
                for name, value in zip(names, row):
                    setattr(each, name, value)

    monkeypatch.setattr(videodev2, 'ioctl', kernel)
    found = media.read_topology(3)
    assert len(asked) == 2
    assert found.names == {1: 'imx219 10-0010', 4: 'unicam-image', 9: 'spare', 12: 'lens'}
    assert found.sensors == {1}
    assert found.videos == {4: (81, 0)}
    assert found.subdevices == {1: (81, 7)}
    assert found.links == ((1, 4),)
    assert found.apart == {12}
