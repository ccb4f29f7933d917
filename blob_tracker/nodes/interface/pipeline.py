"""What the pipeline shows of itself, besides its nodes."""

from blob_tracker.nodes.interface.topics import (
    CAMERA_IMAGE, CAMERA_INFO, RAY, TRACK, WINDOW_IMAGE, WINDOW_INFO,
)
from blob_tracker.ros.interface import Interface, Parameter

# The nodes of the process: those of each `source`, and those that are always there.
SOURCES: dict[str, tuple[str, ...]] = {
    'camera': ('camera',), 'simulator': ('simulator',), 'images': (),
}
CHAIN = ('segmenter', 'locator', 'tracker')
# What one of them takes from another in memory, not from the topic.
HANDED_OVER = (CAMERA_IMAGE, CAMERA_INFO, WINDOW_IMAGE, WINDOW_INFO, RAY, TRACK)

PARAMETERS = (
    Parameter(
        'source',
        next(iter(SOURCES)),
        'Where the frames come from. camera: a V4L2 camera, by a camera node in this process. '
        'simulator: the simulated one. images: camera/image_raw of any other driver, or a bag.',
        choices=tuple(SOURCES),
        fixed='the nodes of the process are made at its start',
    ),
)
INTERFACE = Interface(
    'pipeline',
    'all of them in one process, each with its own parameters',
    'Runs camera (or simulator), segmenter, locator and tracker in one process and hands frames '
    'over in memory. Nodes, topics, services and parameters are those of the four, see their '
    '--help; '
    'images are published only while somebody subscribes. Besides them it has:',
    PARAMETERS,
    examples=(
        'ros2 run blob_tracker pipeline --ros-args -p device:=/dev/video0 '
        '-p camera_info_url:=camera.yaml',
        'ros2 run blob_tracker pipeline --ros-args -p source:=simulator',
        'ros2 param set /segmenter min_snr 8.0',
    ),
)
