"""What the pipeline shows of itself, besides its nodes."""

from blob_tracker.ros.interface import Parameter

PARAMETERS = (
    Parameter(
        'source',
        'camera',
        'Where the frames come from. camera: a V4L2 camera, by a camera node in this process. '
        'simulator: the simulated one. images: camera/image_raw of any other driver, or a bag.',
        choices=('camera', 'simulator', 'images'),
        fixed='the nodes of the process are made at its start',
    ),
)
