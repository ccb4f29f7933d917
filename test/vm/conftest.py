"""
One boot of a virtual machine with the kernel's V4L2 drivers for all tests of this folder.

The guest scripts run, and the tests look at what they wrote down. To add one: its file and its
name in `GUESTS`. Without the programs for a virtual machine the tests are
skipped, except where CI is set: there they have to run.
"""

from __future__ import annotations

import compileall
import os
from pathlib import Path
import shlex
import subprocess
import sys

import blob_tracker
from blob_tracker.resources import config_path
import pytest
from support.slowness import slowness
from vm import machine
from vm.hdmi_loop import SLOW_SIGNAL
from vm.scene import (
    analogue_frames, blinking_frames, CX, CY, flashing_scene, FX, FY, packed_yuyv, Scene,
)

HERE = Path(__file__).parent
CACHE = HERE.parents[1] / '.cache/vm'
# s without a word of the guest on a quiet machine: the longest of its scripts takes 90, and the
# whole 300. Beside the streaming.
SILENCE = 240.0
# s of streaming at full rate; make soak gives it 300
SOAK = float(os.environ.get('SOAK_SECONDS', 20))
# In the order in which they run; `guest.py` says what the commas and slashes mean. What waits for
# a webcam or a program leaves the processors to those on vivid.
GUESTS = (
    'guest_formats,guest_controls/guest_webcam,guest_loopback,guest_vimc',
    'guest_fields', 'guest_capture', 'guest_composite', 'guest_soak', 'guest_blink',
    'guest_track', 'guest_node',
)
CAMERA_INFO = f"""\
image_width: {SLOW_SIGNAL[0]}
image_height: {SLOW_SIGNAL[1]}
camera_name: vivid
distortion_model: plumb_bob
camera_matrix: {{rows: 3, cols: 3, data: [{FX}, 0, {CX}, 0, {FY}, {CY}, 0, 0, 1]}}
distortion_coefficients: {{rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}}
rectification_matrix: {{rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}
projection_matrix: {{rows: 3, cols: 4, data: [{FX}, 0, {CX}, 0, 0, {FY}, {CY}, 0, 0, 0, 1, 0]}}
"""


@pytest.fixture(scope='session')
def scene() -> Scene:
    """Give the scene that is played in the guest."""
    return flashing_scene()


@pytest.fixture(scope='session')
def results(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the guest; return the folder of what it wrote."""
    packages = machine.missing_tools()
    if packages:
        reason = f'no virtual machine: install the Debian packages {packages}'
        if os.environ.get('CI'):
            pytest.fail(reason)
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp('vivid')
    scene.frames.tofile(folder / 'scene.grey')
    analogue_frames().tofile(folder / 'analogue.grey')
    blinking_frames().tofile(folder / 'blink.grey')
    packed_yuyv(scene.frames).tofile(folder / 'scene.yuyv')
    (folder / 'camera_info.yaml').write_text(CAMERA_INFO)
    boot = machine.build(CACHE)
    for sources in (HERE, Path(blob_tracker.__file__).parent):
        compileall.compile_dir(sources, quiet=1)  # here it takes a twentieth of the time
    environment = {
        name: os.environ[name]
        for name in ('PATH', 'LD_LIBRARY_PATH', 'AMENT_PREFIX_PATH')
        if name in os.environ}
    environment |= {
        # The guest scripts import from vm, as pytest has it.
        'PYTHONPATH': os.pathsep.join(
            filter(None, [str(HERE.parent), os.environ.get('PYTHONPATH')])
        ),
        'HOME': '/run',
        'DRIVERS': str(boot.drivers),
        'OMP_NUM_THREADS': '1',
        'SOAK_SECONDS': str(SOAK),
        # It is asked once, and the machine may be busier before the guest is done.
        'SLOWNESS': f'{2.0 * slowness():.2f}',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'FASTRTPS_DEFAULT_PROFILES_FILE': str(config_path('fastdds.xml')),
    }
    # The emulated processor would compile for minutes: compile for any x86-64 out here instead.
    fits = {'NUMBA_CPU_NAME': 'generic', 'NUMBA_CPU_FEATURES': ''}
    if not fits.items() <= os.environ.items():
        fits['NUMBA_CACHE_DIR'] = str(CACHE / 'numba')  # the package's are for this processor
    compile_kernels = (
        'from blob_tracker.pipeline import compile_ahead; compile_ahead(["maximum_likelihood"])'
    )
    subprocess.run(
        [sys.executable, '-c', compile_kernels], env=os.environ | fits, cwd=folder, check=True
    )
    environment |= fits
    commands = [f'export {name}={shlex.quote(value)}' for name, value in environment.items()]
    commands.append(shlex.join([sys.executable, '-m', 'vm.guest', str(folder), *GUESTS]))
    machine.run(boot, commands, folder, lambda: SILENCE * slowness() + SOAK)
    return folder
