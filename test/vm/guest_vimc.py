"""
Runs in the guest: V4l2Camera and the camera node behind a media controller, the kernel's `vimc`.

The folder gets vimc.json and the node's log.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import json
import os
from pathlib import Path
import signal
import subprocess
from typing import Any

from blob_tracker.capture import CaptureError, V4l2Camera
import numpy as np
from rcl_interfaces.srv import ListParameters
import rclpy
from vm.guest_node import Probe, start, STARTUP
from vm.hdmi_loop import NEXT_FRAME, SLOWNESS, v4l2_ctl

NODES = Path('/sys/class/video4linux')
SENSOR, DEBAYER, SCALER = 'Sensor A', 'Debayer A', 'Scaler'
RAW, COLOUR, INPUT = 'Raw Capture 0', 'RGB/YUV Capture', 'RGB/YUV Input'
WIDTH, HEIGHT = 160, 120
RGB = 'RGB888_1X24'
# pixel format -> its code on the bus
MOSAICS = {'RGGB': 'SRGGB8_1X8', 'GRBG': 'SGRBG8_1X8', 'BG10': 'SBGGR10_1X10'}
COUNT = 10  # frames


@contextmanager
def loaded() -> Iterator[None]:
    """Load the driver, and unload it."""
    subprocess.run(['insmod', f"{os.environ['DRIVERS']}/vimc.ko"], check=True)
    try:
        yield
    finally:
        subprocess.run(['rmmod', 'vimc'], check=True)


def device_of(entity: str) -> str:
    """Return the device of a part of the camera."""
    return next(
        f'/dev/{each.name}' for each in NODES.iterdir()
        if (each / 'name').read_text().strip() == entity)


def media_ctl(*options: str) -> None:
    """Run media-ctl."""
    subprocess.run(['media-ctl', '-d', 'platform:vimc', *options], check=True,
                   timeout=30 * SLOWNESS, stdout=subprocess.DEVNULL)


def set_formats(*pads: tuple[str, int, str]) -> None:
    """Set the code of pads, each an entity and its number, at one size."""
    media_ctl('--set-v4l2', ', '.join(
        f'"{entity}":{pad}[fmt:{code}/{WIDTH}x{HEIGHT}]' for entity, pad, code in pads))


def set_mosaic(code: str) -> None:
    """Set the sensor, and what turns its mosaic into colours."""
    set_formats((SENSOR, 0, code), (DEBAYER, 0, code), (SCALER, 0, RGB), (SCALER, 1, RGB))


def refusal(entity: str, pixel_format: str = '', width: int = WIDTH) -> str:
    """Return the sentence with which a device is refused, '' if it is not."""
    try:
        V4l2Camera(device_of(entity), width, HEIGHT, pixel_format).close()
    except CaptureError as error:
        return str(error)
    return ''


def refusals() -> dict[str, str]:
    """Return what is said where formats or links do not fit, until they do."""
    found = {'as loaded': refusal(RAW)}
    set_mosaic(MOSAICS['RGGB'])
    found['another size'] = refusal(RAW, 'RGGB', width=2 * WIDTH)
    found['another code'] = refusal(RAW, 'GRBG')
    found['another way'] = refusal(RAW, 'RGGB')  # that to the other video device
    v4l2_ctl(device_of(COLOUR), f'--set-fmt-video=width={WIDTH},height={HEIGHT},pixelformat=RGB3')
    found['all fit'] = refusal(RAW, 'RGGB')
    return found


def mosaic(pixel_format: str) -> dict[str, Any]:
    """Look at red through a mosaic; give the level at each of its four places."""
    set_mosaic(MOSAICS[pixel_format])
    with V4l2Camera(device_of(RAW), WIDTH, HEIGHT, pixel_format, channel='auto') as camera:
        camera.set_control('test_pattern', '100% Red')
        camera.set_control('show_information', 'None')
        frames = [camera.read(NEXT_FRAME) for _ in range(COUNT)]
        image = frames[-1].image
        return {
            'layout': frames[-1].layout, 'saturation': frames[-1].saturation,
            'shape': image.shape, 'flat': all(
                np.ptp(image[row::2, column::2]) == 0 for row in (0, 1) for column in (0, 1)),
            'places': image[:2, :2].tolist(), 'drops': camera.drops,
            'stamps': [frame.stamp_ns for frame in frames], 'frame_rate': camera.frame_rate}


def ways() -> dict[str, Any]:
    """Return which sensor is found at the other video device, by its links."""
    found: dict[str, Any] = {}
    with V4l2Camera(device_of(COLOUR), WIDTH, HEIGHT, 'RGB3') as camera:
        camera.read(NEXT_FRAME)
        found['linked'] = [camera.sensor, sorted(camera.controls)]
    media_ctl('--links', f'"{DEBAYER}":1 -> "{SCALER}":0[0]')
    found['off'] = refusal(COLOUR, 'RGB3')
    found['off, subdevice'] = refusal(DEBAYER)
    set_formats((INPUT, 0, RGB))
    media_ctl('--links', f'"{INPUT}":0 -> "{SCALER}":0[1]')
    with V4l2Camera(device_of(COLOUR), WIDTH, HEIGHT, 'RGB3') as camera:
        camera.read(NEXT_FRAME)
        found['another'] = camera.sensor
    return found


def on_sensor(name: str) -> int:
    """Return the value of a control as v4l2-ctl prints it."""
    text = subprocess.run(
        ['v4l2-ctl', '-d', device_of(SENSOR), '-C', name], check=True, text=True,
        timeout=30 * SLOWNESS, stdout=subprocess.PIPE).stdout
    return int(text.split()[1])


def node(folder: Path) -> dict[str, Any]:
    """Set the sensor's controls as parameters of the node."""
    running = start(folder, 'vimc', device=device_of(RAW), width=WIDTH, height=HEIGHT,
                    pixel_format='RGGB', channel='auto', brightness=99)
    rclpy.init()
    probe = Probe('vimc')
    found: dict[str, Any] = {'starts': probe.until(lambda: probe.frames, STARTUP)}
    probe.until(lambda: 'contrast' in probe.ask(
        ListParameters, 'camera/list_parameters').result.names)
    found['names'] = probe.ask(ListParameters, 'camera/list_parameters').result.names
    found['at the start'] = [probe.get('brightness'), on_sensor('brightness')]
    found['change'] = probe.change(('contrast', 55))
    found['changed'] = on_sensor('contrast')
    found['refused'] = probe.change(('contrast', 256))
    v4l2_ctl(device_of(SENSOR), '-c', 'saturation=3')  # another program
    found['followed'] = probe.until(lambda: probe.get('saturation') == {'saturation': 3})
    probe.until(lambda: probe.statuses)
    found['diagnostics'] = probe.statuses[-1]
    running.send_signal(signal.SIGINT)
    found['exit'] = running.wait(20 * SLOWNESS)
    probe.destroy_node()
    rclpy.try_shutdown()
    return found


def main(folder: Path) -> None:
    """Do all of it."""
    with loaded():
        found: dict[str, Any] = {
            'devices': {name: device_of(name) for name in (
                RAW, COLOUR, SENSOR, DEBAYER, SCALER, 'Sensor B', 'Raw Capture 1', 'Debayer B',
                'Lens A')},
            'refusals': refusals(),
        }
        found['subdevices'] = {
            name: refusal(name) for name in (SENSOR, 'Sensor B', 'Debayer B', 'Lens A')}
        found['mosaics'] = {name: mosaic(name) for name in MOSAICS}
        set_mosaic(MOSAICS['RGGB'])
        found['node'] = node(folder)
        found['ways'] = ways()
    (folder / 'vimc.json').write_text(json.dumps(found, indent=1))
