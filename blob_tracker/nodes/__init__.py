"""What `ros2 run` starts: thin nodes that declare, subscribe, call and publish."""

# The one list of them. setup.py reads it by running this file alone: nothing is imported here.
NODES = (
    'camera', 'segmenter', 'locator', 'tracker', 'triangulator', 'constellation', 'pipeline',
    'simulator',
)
