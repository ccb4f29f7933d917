"""
One boot of a virtual machine with the kernel's `vivid` driver for all tests of this folder.

The guest scripts run one after the other, and the tests look at what they wrote down. To add one:
its file and its line in `guests`. Without the programs for a virtual machine the tests are
skipped, except where CI is set: there they have to run.
"""

from __future__ import annotations

import os
from pathlib import Path
import shlex
import subprocess
import sys

from blob_tracker.resources import config_path
import pytest
from support.processes import executable
from support.slowness import slowness
from vm import machine
from vm.hdmi_loop import SIGNAL
from vm.scene import CX, CY, flashing_scene, FX, FY, packed_yuyv, Scene

HERE = Path(__file__).parent
CACHE = HERE.parents[1] / '.cache/vm'
# s without a word of the guest on a quiet machine: the longest of its scripts takes 90, and the
# whole 300. Beside the streaming.
SILENCE = 240.0
# s of streaming at full rate; make soak gives it 300
SOAK = float(os.environ.get('SOAK_SECONDS', 20))
CAMERA_INFO = f"""\
image_width: {SIGNAL[0]}
image_height: {SIGNAL[1]}
camera_name: vivid
distortion_model: plumb_bob
camera_matrix: {{rows: 3, cols: 3, data: [{FX}, 0, {CX}, 0, {FY}, {CY}, 0, 0, 1]}}
distortion_coefficients: {{rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}}
rectification_matrix: {{rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}
projection_matrix: {{rows: 3, cols: 4, data: [{FX}, 0, {CX}, 0, 0, {FY}, {CY}, 0, 0, 0, 1, 0]}}
"""


def guests(folder: Path) -> list[list[str]]:
    """Return the guest scripts with their arguments, in the order in which they run."""
    return [
        ['guest_capture.py', str(folder)],
        ['guest_formats.py', str(folder)],
        ['guest_controls.py', str(folder)],
        ['guest_fields.py', str(folder)],
        ['guest_soak.py', str(folder), str(SOAK)],
        ['guest_track.py', str(folder), str(executable('camera').parent)],
        ['guest_node.py', str(folder), str(executable('camera').parent)],
    ]


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
    packed_yuyv(scene.frames).tofile(folder / 'scene.yuyv')
    (folder / 'camera_info.yaml').write_text(CAMERA_INFO)
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
        'OMP_NUM_THREADS': '1',
        'SLOWNESS': f'{slowness():.2f}',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'FASTRTPS_DEFAULT_PROFILES_FILE': str(config_path('fastdds.xml')),
    }
    # The emulated processor would compile for minutes: compile for any x86-64 out here instead.
    fits = {
        'NUMBA_CPU_NAME': 'generic',
        'NUMBA_CPU_FEATURES': '',
        'NUMBA_CACHE_DIR': str(CACHE / 'numba'),
    }
    compile_kernels = (
        'from blob_tracker.pipeline import compile_ahead; compile_ahead(["maximum_likelihood"])'
    )
    subprocess.run(
        [sys.executable, '-c', compile_kernels], env=os.environ | fits, cwd=folder, check=True
    )
    environment |= fits
    commands = [f'export {name}={shlex.quote(value)}' for name, value in environment.items()]
    for script, *arguments in guests(folder):
        commands.append(shlex.join([sys.executable, str(HERE / script), *arguments]))
    machine.run(machine.build(CACHE), commands, folder, lambda: SILENCE * slowness() + SOAK)
    return folder
