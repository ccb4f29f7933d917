"""
Runs in the guest: every control, every injected error, stamps and the grabber, on the driver.

The folder gets controls.json.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import dataclasses
from functools import partial
import json
from pathlib import Path
import subprocess
import time
from typing import Any

from blob_tracker.capture import CaptureError, Grabber, stamps, V4l2Camera, videodev2
from blob_tracker.capture.exposure import adjust_exposure
import numpy as np
from vm.hdmi_loop import (
    CAPTURE, close_loop, control, HEIGHT, NEXT_FRAME, SLOWNESS, v4l2_ctl, WIDTH,
)

SETTINGS: dict[str, Any] = {'device': CAPTURE, 'width': WIDTH, 'height': HEIGHT,
                            'pixel_format': 'GREY'}
READOUT = 0.05  # s, longer than 0.9 frames
# name -> values to set; what is read back is written down
ROUND_TRIPS: dict[str, list[Any]] = {
    'brightness': [0, 255, 77.0],
    'integer_32_bits': [-2147483648, 2147483647],
    'integer_64_bits': [-9223372036854775808, 9223372036854775807, -3],
    'boolean': [False, True, 0, 1],
    'menu': [1, 4, 'Menu Item 3'],
    'integer_menu': [2, '42', 8],
    'bitmask': [0, 0x80402010, 0x80000000, 0x400010],
    'string': ['ab', 'abcd', 'ä '],
}
REFUSALS: dict[str, tuple[str, Any]] = {
    'no_such': ('exposure_time', 1),
    'range': ('brightness', 256),
    'range_64': ('integer_64_bits', 2**63),
    'fraction': ('brightness', 1.5),
    'nan': ('brightness', float('nan')),
    'truth': ('brightness', True),
    'text': ('brightness', 'bright'),
    'hole': ('menu', 2),
    'menu_text': ('menu', 'Menu Item 2'),
    'integer_menu': ('integer_menu', 1),
    'boolean': ('boolean', 2),
    'bitmask': ('bitmask', 1),
    'negative_bitmask': ('bitmask', -1),
    'short_string': ('string', 'a'),
    'string_number': ('string', 12),
    'button': ('button', False),
    'read_only': ('read_only_integer_32_bits', 1),
}


def sentence(action: Callable[[], Any]) -> str:
    """Return the sentence with which something is refused, '' if it is not."""
    try:
        action()
    except CaptureError as error:
        return f'{type(error).__name__}: {error}'
    return ''


def listing(camera: V4l2Camera) -> dict[str, Any]:
    """Return the controls as the camera has them and as v4l2-ctl prints them."""
    found = {}
    for name, made in camera.controls.items():
        # By hand, as a mapping proxy is not copied by dataclasses.asdict.
        found[name] = {field.name: getattr(made, field.name)
                       for field in dataclasses.fields(made)} | {'menu': dict(made.menu)}
        if made.kind != 'button':
            found[name]['value'] = camera.get_control(name)
    text = subprocess.run(['v4l2-ctl', '-d', CAPTURE, '-L'], check=True, timeout=60 * SLOWNESS,
                          stdout=subprocess.PIPE).stdout.decode(errors='replace')
    return {'controls': found, 'v4l2_ctl': text}


def round_trips(camera: V4l2Camera) -> dict[str, Any]:
    """Set each kind of control to some values and read it again; put it back."""
    found: dict[str, Any] = {}
    for name, values in ROUND_TRIPS.items():
        before = camera.get_control(name)
        found[name] = []
        for value in values:
            camera.set_control(name, value)
            found[name].append(camera.get_control(name))
        camera.set_control(name, before)
    camera.set_control('button', True)
    return found


def effects(camera: V4l2Camera) -> dict[str, Any]:
    """Return how a control changes another one's flags and value."""
    found: dict[str, Any] = {}
    for automatic in (True, False):
        camera.set_control('gain_automatic', automatic)
        gain = camera.controls['gain']
        found[str(automatic)] = {'inactive': gain.inactive, 'volatile': gain.volatile}
    camera.set_control('gain', 33)
    found['gain'] = camera.get_control('gain')
    camera.set_control('gain_automatic', True)
    return found


@contextmanager
def brightness_as_exposure() -> Iterator[None]:
    """Let the brightness stand for the exposure time, which the driver has not."""
    number = next(made.number for made in controls_of().values() if made.name == 'brightness')
    kept = videodev2.CID_EXPOSURE_ABSOLUTE, stamps.WATCHED
    watched: Any = (number,)
    videodev2.CID_EXPOSURE_ABSOLUTE, stamps.WATCHED = number, watched
    try:
        yield
    finally:
        videodev2.CID_EXPOSURE_ABSOLUTE, stamps.WATCHED = kept


def controls_of() -> dict[str, Any]:
    """Return the controls of the device."""
    with V4l2Camera(**SETTINGS) as camera:
        return dict(camera.controls)


def exposures() -> dict[str, Any]:
    """Change the exposure while frames come, from here and from another program."""
    found: dict[str, Any] = {'changes': []}
    seen: list[list[int]] = []
    # The driver's end of a frame lies 0.9 frames ahead of its delivery (see `stamps`).
    control(timestamp_source=0)
    with brightness_as_exposure(), V4l2Camera(**SETTINGS, readout_time=READOUT) as camera:
        place = camera.stamp_place
        middle_of = camera._middle.middle

        def noted(stamp_ns: int, read_ns: int) -> int:
            middle = middle_of(stamp_ns, read_ns)
            seen.append([stamp_ns, middle, read_ns])
            return middle

        camera._middle.middle = noted  # type: ignore[method-assign]
        frames = []
        for change in (lambda: None,
                       lambda: camera.set_control('brightness', 200),
                       lambda: control(brightness=50),
                       lambda: camera.set_control('brightness', 150)):
            before = time.monotonic_ns()
            change()
            found['changes'].append([before, time.monotonic_ns()])
            frames += [camera.read(NEXT_FRAME).stamp_ns for _ in range(12)]
        found |= {'readout_s': READOUT, 'units': [128, 200, 50, 150], 'place': place,
                  'seen': seen, 'frames': frames}
        camera.set_control('brightness', 128)
    for name, source, arguments in (
            ('start', 1, dict[str, Any]()), ('start_known', 1, {'exposure_time': 0.01}),
            ('end', 0, {}),
            ('end_exposure', 0, {'exposure_time': 0.01}),
            ('end_known', 0, {'exposure_time': 0.01, 'readout_time': 0.02})):
        control(timestamp_source=source)
        with V4l2Camera(**SETTINGS, **arguments) as camera:
            camera.read(NEXT_FRAME)
            found[name] = camera.stamp_place
    control(timestamp_source=1)
    return found


def grabbing() -> dict[str, Any]:
    """Read through the thread: at ease, too slowly, over a silence of the driver."""
    found: dict[str, Any] = {}
    with V4l2Camera(**SETTINGS) as camera:
        dequeued: list[int] = []
        take = camera._ring.take

        def noted() -> Any:
            buffer = take()
            if buffer is not None:
                dequeued.append(time.monotonic_ns())
            return buffer

        camera._ring.take = noted  # type: ignore[method-assign]
        with Grabber(camera) as grabber:
            grabber.newest(NEXT_FRAME)
            latencies = []
            for _ in range(60):
                grabber.newest(NEXT_FRAME)
                latencies.append(time.monotonic_ns() - dequeued[-1])
            found['latency_us'] = sorted(latency / 1e3 for latency in latencies)
            image = np.zeros((HEIGHT, WIDTH), np.uint8)
            began = time.monotonic_ns()
            for _ in range(100):
                image.copy()
            found['copy_us'] = (time.monotonic_ns() - began) / 1e5
            stamps_ns = []
            for _ in range(10):
                time.sleep(0.1)
                stamps_ns.append(grabber.newest(NEXT_FRAME).stamp_ns)
            found['slow_stamps'], found['slow_overruns'] = stamps_ns, grabber.overruns
            time.sleep(1.0)
            woken_ns = time.time_ns()
            found['older_than_wake_s'] = (woken_ns - grabber.newest(NEXT_FRAME).stamp_ns) / 1e9
            # The reader and then the driver stall: what is in the slot is no new frame.
            control(percentage_of_dropped_buffers=100)
            time.sleep(1.0)
            found['quiet'] = sentence(lambda: grabber.newest(0.7))
            control(percentage_of_dropped_buffers=0)
            found['after_quiet'] = sentence(lambda: grabber.newest(NEXT_FRAME))
        found['closed'] = sentence(lambda: grabber.newest(NEXT_FRAME))
        found['ended'] = not grabber._thread.is_alive()
        found['camera_lives'] = sentence(lambda: camera.read(NEXT_FRAME))
    return found


def ended(inject: Callable[[], None]) -> dict[str, Any]:
    """Return how a running grabber takes an error; and whether the device opens again."""
    with V4l2Camera(**SETTINGS) as camera, Grabber(camera) as grabber:
        grabber.newest(NEXT_FRAME)
        inject()
        found: dict[str, Any] = {'sentence': sentence(lambda: some(grabber)),
                                 'again': sentence(lambda: grabber.newest(NEXT_FRAME)),
                                 'controls': sentence(lambda: camera.controls)}
        grabber.close()
        found['ended'] = not grabber._thread.is_alive()
    found['reopened'] = sentence(opened)
    return found


def some(grabber: Grabber, count: int = 30) -> None:
    """Read some frames."""
    for _ in range(count):
        grabber.newest(NEXT_FRAME)


def opened() -> None:
    """Open the device and read a frame."""
    with V4l2Camera(**SETTINGS) as camera:
        camera.read(NEXT_FRAME)


def refused(button: str) -> dict[str, str]:
    """Return how opening takes an error, and the opening after that."""
    v4l2_ctl(CAPTURE, '-c', f'{button}=1')
    return {'sentence': sentence(opened), 'reopened': sentence(opened)}


def injections() -> dict[str, Any]:
    """Let the driver fail in all the ways that it can."""
    found: dict[str, Any] = {
        button: refused(f'inject_vidioc_{button}_error')
        for button in ('reqbufs', 'qbuf', 'streamon')}
    for name, button in (('qbuf_running', 'inject_vidioc_qbuf_error'),
                         ('fatal', 'inject_fatal_streaming_error')):
        found[name] = ended(partial(v4l2_ctl, CAPTURE, '-c', f'{button}=1'))
    with V4l2Camera(**SETTINGS) as camera, Grabber(camera) as grabber:
        first = grabber.newest(NEXT_FRAME).stamp_ns
        for _ in range(10):
            camera.set_control('inject_v4l2_buf_flag_error', True)
            some(grabber, 2)
        control(percentage_of_dropped_buffers=50)
        some(grabber)
        control(percentage_of_dropped_buffers=0)
        last = grabber.newest(NEXT_FRAME).stamp_ns
        found['ridden_out'] = {'drops': grabber.drops, 'seconds': (last - first) / 1e9}
    found['disconnect'] = ended(lambda: v4l2_ctl(CAPTURE, '-c', 'disconnect=1'))
    return found


def search() -> dict[str, Any]:
    """Search on the driver's picture, to which brightness and contrast add and multiply."""
    with V4l2Camera(**SETTINGS) as camera:
        found: dict[str, Any] = {}
        for name, pattern, exposure, gain in (
                ('found', '100% White', 'contrast', 'brightness'),
                # Neither makes a difference to grey.
                ('too bright', '100% White', 'saturation', 'hue'),
                ('too dark', '100% Black', 'saturation', 'hue')):
            camera.set_control('test_pattern', pattern)
            outcome = adjust_exposure(
                camera, lambda: camera.read(NEXT_FRAME), exposure=exposure, gain=gain, frames=2,
                settling=1)
            found[name] = dataclasses.asdict(outcome) | {
                'left': [camera.get_control(exposure), camera.get_control(gain)],
                'seen': float(camera.read(NEXT_FRAME).image.max()) / 255}
            for changed in ('brightness', 'contrast'):
                camera.set_control(changed, camera.controls[changed].default)
        camera.set_control('test_pattern', 0)
        camera.set_control('saturation', 128)
        camera.set_control('hue', 0)
        camera.set_control('gain_automatic', True)
    return found


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop()
    found: dict[str, Any] = {}
    with V4l2Camera(**SETTINGS) as camera:
        found['listing'] = listing(camera)
        found['round_trips'] = round_trips(camera)
        found['refusals'] = {
            name: sentence(lambda: camera.set_control(*case)) for name, case in REFUSALS.items()}
        found['unreadable'] = sentence(lambda: camera.get_control('button'))
        found['effects'] = effects(camera)
    found['closed'] = sentence(lambda: camera.get_control('brightness'))
    control(loop_video=0)  # the driver's own picture, which answers to its controls
    for name, part in (('exposures', exposures), ('grabbing', grabbing), ('search', search),
                       ('injections', injections)):
        began = time.monotonic()
        found[name] = part()
        found[name]['took_s'] = time.monotonic() - began
    control(loop_video=1)
    (folder / 'controls.json').write_text(json.dumps(found, indent=1))
