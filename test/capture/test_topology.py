"""Which sensor feeds a video device, in topologies of the shape that media-ctl -p prints."""

from __future__ import annotations

import re

from blob_tracker.capture.topology import fed_by, Node, Sensor, sensor_of, Topology
import pytest

NODES = {f'/dev/{name}{number}': (81, offset + number)
         for name, offset in (('video', 0), ('v4l-subdev', 100)) for number in range(30)}

# Raspberry Pi 4: the sensor has an output for embedded data as well.
UNICAM = """
- entity 1: imx219 10-0010 (2 pads, 2 links)
            type V4L2 subdev subtype Sensor flags 0
            device node name /dev/v4l-subdev0
    pad0: Source
        -> "unicam-image":0 [ENABLED,IMMUTABLE]
    pad1: Source
        -> "unicam-embedded":0 [ENABLED,IMMUTABLE]
- entity 4: unicam-image (1 pad, 1 link)
            type Node subtype V4L flags 1
            device node name /dev/video0
- entity 10: unicam-embedded (1 pad, 1 link)
            type Node subtype V4L flags 0
            device node name /dev/video1
"""
# Raspberry Pi 5: a receiver, and the front end of the ISP, whose links are not enabled.
CFE = """
- entity 1: csi2 (8 pads, 9 links)
            type V4L2 subdev subtype Unknown flags 0
            device node name /dev/v4l-subdev0
    pad4: Source
        -> "rp1-cfe-csi2_ch0":0 [ENABLED]
        -> "pisp-fe":0 []
    pad5: Source
        -> "rp1-cfe-embedded":0 []
- entity 10: pisp-fe (5 pads, 5 links)
             type V4L2 subdev subtype Unknown flags 0
             device node name /dev/v4l-subdev1
    pad2: Source
        -> "rp1-cfe-fe_image0":0 []
- entity 16: ov9281 10-0060 (1 pad, 1 link)
             type V4L2 subdev subtype Sensor flags 0
             device node name /dev/v4l-subdev2
    pad0: Source
        -> "csi2":0 [ENABLED,IMMUTABLE]
- entity 17: dw9807 10-000c (0 pad, 0 link)
             type V4L2 subdev subtype Lens flags 0
             device node name /dev/v4l-subdev3
- entity 18: rp1-cfe-csi2_ch0 (1 pad, 1 link)
             type Node subtype V4L flags 0
             device node name /dev/video0
- entity 22: rp1-cfe-embedded (1 pad, 1 link)
             type Node subtype V4L flags 0
             device node name /dev/video1
- entity 34: rp1-cfe-fe_image0 (1 pad, 1 link)
             type Node subtype V4L flags 1
             device node name /dev/video4
"""
# i.MX 8M Plus: receiver, crossbar, channel; two sensors, one of them behind a link that is off.
ISI = """
- entity 1: crossbar (5 pads, 4 links)
            type V4L2 subdev subtype Unknown flags 0
            device node name /dev/v4l-subdev0
    pad3: Source
        -> "mxc_isi.0":0 [ENABLED,IMMUTABLE]
- entity 8: mxc_isi.0 (2 pads, 2 links)
            type V4L2 subdev subtype Unknown flags 0
            device node name /dev/v4l-subdev1
    pad1: Source
        -> "mxc_isi.0.capture":0 [ENABLED,IMMUTABLE]
- entity 11: mxc_isi.0.capture (1 pad, 1 link)
             type Node subtype V4L flags 0
             device node name /dev/video2
- entity 30: csis-32e40000.csi (2 pads, 3 links)
             type V4L2 subdev subtype Unknown flags 0
             device node name /dev/v4l-subdev3
    pad1: Source
        -> "crossbar":0 [ENABLED,IMMUTABLE]
- entity 35: ov5640 1-003c (1 pad, 1 link)
             type V4L2 subdev subtype Sensor flags 0
             device node name /dev/v4l-subdev4
    pad0: Source
        -> "csis-32e40000.csi":0 [ENABLED]
- entity 40: ar0144 2-0010 (1 pad, 1 link)
             type V4L2 subdev subtype Sensor flags 0
             device node name /dev/v4l-subdev5
    pad0: Source
        -> "csis-32e40000.csi":0 []
"""
# A sensor whose pixel array, binner and scaler are entities of their own (ccs).
CCS = """
- entity 1: ccs pixel_array 2-0010 (1 pad, 1 link)
            type V4L2 subdev subtype Sensor flags 0
            device node name /dev/v4l-subdev0
    pad0: Source
        -> "ccs binner 2-0010":0 [ENABLED,IMMUTABLE]
- entity 3: ccs binner 2-0010 (2 pads, 2 links)
            type V4L2 subdev subtype Unknown flags 0
            device node name /dev/v4l-subdev1
    pad1: Source
        -> "OMAP3 ISP CSI2a":0 [ENABLED]
- entity 6: OMAP3 ISP CSI2a (2 pads, 2 links)
            type V4L2 subdev subtype Unknown flags 0
    pad1: Source
        -> "OMAP3 ISP CSI2a output":0 [ENABLED]
- entity 9: OMAP3 ISP CSI2a output (1 pad, 1 link)
            type Node subtype V4L flags 0
            device node name /dev/video0
"""
# A webcam: its parts have no nodes of their own.
WEBCAM = """
- entity 1: HD Webcam (1 pad, 1 link)
            type Node subtype V4L flags 1
            device node name /dev/video0
- entity 8: Processing 2 (2 pads, 2 links)
            type V4L2 subdev subtype Unknown flags 0
    pad1: Source
        -> "HD Webcam":0 [ENABLED,IMMUTABLE]
- entity 11: Camera 1 (1 pad, 1 link)
             type V4L2 subdev subtype Sensor flags 0
    pad0: Source
        -> "Processing 2":0 [ENABLED,IMMUTABLE]
"""


def topology(text: str) -> Topology:
    """Return what media-ctl printed."""
    names: dict[int, str] = {}
    sensors: set[int] = set()
    videos: dict[int, Node] = {}
    subdevices: dict[int, Node] = {}
    links: list[tuple[int, str]] = []
    apart: set[int] = set()
    for line in text.splitlines():
        if found := re.match(r'- entity (\d+): (.*) \(\d+ pad', line):
            entity = int(found[1])
            names[entity] = found[2]
            if ' 0 link)' in line:
                apart.add(entity)
        elif 'subtype Sensor' in line:
            sensors.add(entity)
        elif found := re.search('device node name (.*)', line):
            (videos if 'video' in found[1] else subdevices)[entity] = NODES[found[1]]
        elif found := re.search(r'-> "(.*)":\d+ \[ENABLED', line):
            links.append((entity, found[1]))
    numbers = {name: number for number, name in names.items()}
    return Topology(
        names, frozenset(sensors), videos, subdevices,
        tuple((source, numbers[sink]) for source, sink in links), frozenset(apart))


@pytest.mark.parametrize(('text', 'video', 'name', 'subdevices'), [
    (UNICAM, 0, 'imx219 10-0010', [0]),
    (CFE, 0, 'ov9281 10-0060', [2, 0]),
    (ISI, 2, 'ov5640 1-003c', [4, 3, 0, 1]),
    (CCS, 0, 'ccs pixel_array 2-0010', [0, 1]),
    (WEBCAM, 0, 'Camera 1', []),
])
def test_the_sensor_is_the_one_that_is_linked(text, video, name, subdevices):
    assert sensor_of(topology(text), NODES[f'/dev/video{video}']) == Sensor(
        name, tuple(NODES[f'/dev/v4l-subdev{number}'] for number in subdevices))


@pytest.mark.parametrize(('text', 'video'), [
    (CFE, 4),  # its links are not enabled
    (CFE, 9),  # of another media device
    (ISI.replace(':0 []', ':0 [ENABLED]'), 2),  # two at once: nobody knows which
])
def test_no_sensor_is_made_up(text, video):
    assert sensor_of(topology(text), NODES[f'/dev/video{video}']) is None


@pytest.mark.parametrize(('text', 'subdevice', 'name', 'videos'), [
    (UNICAM, 0, 'imx219 10-0010', [0, 1]),
    (CFE, 2, 'ov9281 10-0060', [0]),
    (CFE, 1, 'pisp-fe', []),
    (ISI, 5, 'ar0144 2-0010', []),
])
def test_a_subdevice_is_named_with_what_it_feeds(text, subdevice, name, videos):
    found = fed_by(topology(text), NODES[f'/dev/v4l-subdev{subdevice}'])
    assert found == (name, [NODES[f'/dev/video{number}'] for number in videos])
    assert fed_by(topology(text), NODES['/dev/v4l-subdev29']) is None


def test_a_lens_feeds_nothing():
    assert fed_by(topology(CFE), NODES['/dev/v4l-subdev3']) == ('dw9807 10-000c', None)


def test_links_that_run_in_a_circle_end():
    circle = topology(UNICAM)
    again = Topology(
        circle.names, circle.sensors, circle.videos, circle.subdevices, (*circle.links, (4, 1)))
    found = sensor_of(again, NODES['/dev/video0'])
    assert found is not None and found.name == 'imx219 10-0010'
