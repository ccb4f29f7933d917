"""
Runs in the guest: the camera node on the driver, its parameters, services and diagnostics.

The folder gets node.json and a log of each node.
"""

from __future__ import annotations

from collections.abc import Callable
import json
from pathlib import Path
import re
import signal
import subprocess
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import (
    DescribeParameters, GetParameters, ListParameters, SetParameters, SetParametersAtomically,
)
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from sensor_msgs.msg import CameraInfo, Image
from sensor_msgs.srv import SetCameraInfo
from std_srvs.srv import Trigger
from vm.fork import Fork, node
from vm.hdmi_loop import (
    CAPTURE, close_loop, control, HEIGHT, SLOW_SIGNAL, slow_timings, SLOWNESS, v4l2_ctl, WIDTH,
)

TIMINGS = slow_timings(34_000_000)  # 7.7 Hz: each frame takes an emulated processor long
SPARE = '/dev/video2'  # for nodes that are not meant to run for long
STARTUP = 90.0 * SLOWNESS  # s: Python and its imports on an emulated processor
PATIENCE = 40.0 * SLOWNESS  # s; a second is enough on a quiet machine
DESCRIBED = ('brightness', 'menu', 'string', 'integer_64_bits', 'button', 'boolean', 'bitmask',
             'read_only_integer_32_bits', 'gain')
# What is set one after the other while the node streams: name, value.
SETS: tuple[tuple[str, Any], ...] = (
    ('brightness', 200), ('integer_64_bits', -2**40), ('string', 'abc'), ('boolean', False),
    ('menu', 4), ('bitmask', 0x80000000), ('button', True),
    ('brightness', 256), ('menu', 2), ('string', 'a'), ('button', False), ('brightness', 'high'),
    ('read_only_integer_32_bits', 1),
)


class Probe(Node):
    """Call the node's services and keep what it publishes, in a namespace."""

    def __init__(self, namespace: str = '') -> None:
        super().__init__('probe', namespace=namespace)
        self.infos: list[CameraInfo] = []
        self.frames = 0
        self.statuses: list[tuple[int, str, dict[str, str]]] = []
        self.create_subscription(CameraInfo, 'camera/camera_info', self.infos.append, 10)
        self.create_subscription(Image, 'camera/image_raw', self._image, 10)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._diagnostics, 100)
        self._known: dict[str, Any] = {}

    def ask(self, kind: Any, name: str, **fields: Any) -> Any:
        """Call a service of the node and return its answer."""
        client = self._known.setdefault(name, self.create_client(kind, name))
        self.until(client.service_is_ready, STARTUP)
        future = client.call_async(kind.Request(**fields))
        self.until(future.done)
        return future.result()

    def until(self, done: Callable[[], Any], longest: float = PATIENCE) -> bool:
        """Wait until a condition holds; return whether it came to that."""
        end = time.monotonic() + longest
        while not done() and time.monotonic() < end:
            rclpy.spin_once(self, timeout_sec=0.2)
        return bool(done())

    def change(self, *parameters: tuple[str, Any], at_once: bool = False) -> str:
        """Set parameters; return why they were refused, '' if they were not."""
        messages = [Parameter(name, value=value).to_parameter_msg() for name, value in parameters]
        if at_once:
            return self.ask(SetParametersAtomically, 'camera/set_parameters_atomically',
                            parameters=messages).result.reason
        answer = self.ask(SetParameters, 'camera/set_parameters', parameters=messages)
        return '; '.join(result.reason for result in answer.results if not result.successful)

    def get(self, *names: str) -> dict[str, Any]:
        """Return the values of parameters."""
        values = self.ask(GetParameters, 'camera/get_parameters', names=list(names)).values
        return dict(zip(names, map(parameter_value_to_python, values)))

    def said(self, level: int, words: str) -> Callable[[], bool]:
        """Return a condition: a diagnostic from now on has this level and these words."""
        seen = len(self.statuses)
        return lambda: any(
            status[0] == level and words in status[1] for status in self.statuses[seen:])

    def _image(self, _: Image) -> None:
        self.frames += 1

    def _diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.startswith(f"{self.get_namespace().rstrip('/')}/camera"):
                values = {pair.key: pair.value for pair in status.values}
                self.statuses.append((status.level[0], status.message, values))


def start(folder: Path, log: str, **parameters: Any) -> Fork:
    """Start a camera node in a namespace of its log's name, `node` in none."""
    arguments = ['--ros-args']
    if log != 'node':
        arguments += ['-r', f'__ns:=/{log}']
    for name, value in parameters.items():
        arguments += ['-p', f'{name}:={value}']
    action = node('camera', *arguments, ROS_HOME=str(folder / 'ros_home'))
    return Fork(action, folder / f'{log}.log').begin()


def listed() -> list[str]:
    """Return the names of the device's controls as v4l2-ctl lists them."""
    text = subprocess.run(['v4l2-ctl', '-d', CAPTURE, '-l'], check=True, text=True,
                          errors='replace', stdout=subprocess.PIPE, timeout=60 * SLOWNESS).stdout
    # Arrays, such as u32 and rectangles, have no value of one number: elems, dims.
    return re.findall(r'^ *(\w+) 0x\w+ \((?:int|int64|bool|menu|intmenu|str|bitmask|button)\)'
                      r'(?!.*(?:elems|dims)=)', text, re.MULTILINE)


def read(name: str) -> str:
    """Return the value of a control as v4l2-ctl prints it."""
    text = subprocess.run(['v4l2-ctl', '-d', CAPTURE, '-C', name], check=True, text=True,
                          errors='replace', stdout=subprocess.PIPE, timeout=60 * SLOWNESS).stdout
    return text.partition(':')[2].split('(')[0].strip(" \n'")


def calibration(width: int, height: int) -> CameraInfo:
    """Return a calibration of this size that the service is given."""
    return CameraInfo(width=width, height=height, distortion_model='plumb_bob', d=[0.0] * 5,
                      k=[400.5, 0.0, 160.0, 0.0, 401.5, 120.0, 0.0, 0.0, 1.0])


def parameters(probe: Probe) -> dict[str, Any]:
    """Look at the parameters and set them."""
    found: dict[str, Any] = {'controls': listed()}
    # In a moment, as they are declared after the device was opened.
    probe.until(lambda: 'gain' in probe.ask(ListParameters, 'camera/list_parameters').result.names)
    found['names'] = probe.ask(ListParameters, 'camera/list_parameters').result.names
    found['at_start'] = probe.get('contrast', 'gain_automatic') | {
        f'v4l2_ctl {name}': read(name) for name in ('contrast', 'gain_automatic')}
    answer = probe.ask(DescribeParameters, 'camera/describe_parameters', names=list(DESCRIBED))
    found['described'] = {
        each.name: [each.type, each.description, [
            [part.from_value, part.to_value, part.step] for part in each.integer_range]]
        for each in answer.descriptors}
    found['sets'] = [[name, value, probe.change((name, value))] for name, value in SETS]
    found['after'] = {name: read(name) for name in
                      ('brightness', 'integer_64_bits', 'string', 'boolean', 'menu', 'bitmask')}
    found['springs_back'] = probe.until(lambda: probe.get('button') == {'button': False})
    found['all_or_none'] = probe.change(('brightness', 11), ('menu', 2), at_once=True)
    found['none'] = read('brightness')
    # The mode comes first, whatever the order in the request.
    found['mode_and_governed'] = probe.change(
        ('gain', 44), ('gain_automatic', False), at_once=True)
    found['gain'] = read('gain')

    control(contrast=12)  # another program
    found['followed'] = probe.until(lambda: probe.get('contrast') == {'contrast': 12})
    found['not_fought'] = read('contrast')

    warned = probe.said(1, "'gain_automatic' is true: ")
    found['automatic'] = probe.change(('gain_automatic', True))
    found['warned'] = probe.until(warned)
    found['inactive'] = probe.change(('gain', 45))
    found['manual'] = probe.change(('gain_automatic', False))
    return found


def services(probe: Probe, folder: Path) -> dict[str, Any]:
    """Give the node calibrations and let it search for the exposure."""
    found: dict[str, Any] = {}
    answer = probe.ask(
        SetCameraInfo, 'camera/set_camera_info', camera_info=calibration(WIDTH, HEIGHT))
    found['other_size'] = [answer.success, answer.status_message]
    found['uncalibrated'] = list(probe.infos[-1].k)
    answer = probe.ask(
        SetCameraInfo, 'camera/set_camera_info', camera_info=calibration(*SLOW_SIGNAL))
    found['calibrated'] = [answer.success, answer.status_message]
    found['takes_effect'] = probe.until(lambda: probe.infos[-1].k[0] == 400.5)
    found['stored'] = (folder / 'ros_home/camera_info/camera.yaml').exists()
    frames = probe.frames
    answer = probe.ask(Trigger, 'camera/find_exposure')
    found['exposure'] = [answer.success, answer.message]
    found['frames_meanwhile'] = probe.frames - frames
    found['gain'] = [probe.get('gain'), read('gain')]
    return found


def unplugged(probe: Probe) -> dict[str, Any]:
    """Unplug the camera, change its controls behind the node's back, and plug it in again."""
    found: dict[str, Any] = {}
    found['before'] = probe.change(('brightness', 77), ('string', 'xyz'))
    # So long as there is no signal the node cannot take the device up again.
    control(dv_timings_signal_mode=1)
    gone = probe.said(2, 'the device is gone (unplugged?)')
    waits = probe.said(2, 'no signal')
    v4l2_ctl(CAPTURE, '-c', 'disconnect=1')
    found['gone'] = probe.until(gone)
    found['waits'] = probe.until(waits)
    found['refused'] = probe.change(('brightness', 78))
    answer = probe.ask(Trigger, 'camera/find_exposure')
    found['exposure'] = [answer.success, answer.message]
    control(brightness=5, contrast=5, string='ab', gain_automatic=1)
    frames = probe.frames
    control(dv_timings_signal_mode=0)
    found['resumed'] = probe.until(lambda: probe.frames > frames)
    found['restored'] = {name: read(name) for name in
                         ('brightness', 'contrast', 'string', 'gain_automatic')}
    found['shown'] = probe.until(lambda: probe.get('brightness', 'contrast') == {
        'brightness': 77, 'contrast': 99})
    return found


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop(timings=TIMINGS)
    control(gain_automatic=1, contrast=128)
    running = start(folder, 'node', device=CAPTURE, width=WIDTH, height=HEIGHT,
                    pixel_format='GREY', contrast=99)
    wrong = {
        'misspelt': start(folder, 'misspelt', device=SPARE, brigthness=5),
        'refused': start(folder, 'refused', device=SPARE, brightness=256),
    }
    rclpy.init()
    probe = Probe()
    found: dict[str, Any] = {'starts': probe.until(lambda: probe.frames, STARTUP)}
    found['parameters'] = parameters(probe)
    found['services'] = services(probe, folder)
    found['unplugged'] = unplugged(probe)
    # An emulated processor may be too slow for all of the frames, and says so.
    streams, loses = probe.said(0, 'streaming'), probe.said(1, 'of the last frames were lost')
    probe.until(lambda: streams() or loses())
    found['diagnostics'] = probe.statuses[-1]
    for name, process in wrong.items():
        found[name] = process.wait(STARTUP)
    running.send_signal(signal.SIGINT)
    found['exit'] = running.wait(20)
    (folder / 'node.json').write_text(json.dumps(found, indent=1))
    probe.destroy_node()
    rclpy.try_shutdown()
