#!/usr/bin/env python3
"""
Write the frames of a simulated light as PNG files, to try `blob_tracker track` on.

    python3 examples/simulated_frames.py light
    blob_tracker track light --frame-rate 60 --field-of-view 56 --annotate

The light is on in every other frame and goes round before a textured wall.
"""

import argparse
from pathlib import Path

from blob_tracker.simulation import flashing_light
import cv2

FRAMES = 200  # at 60 frames/s


def main() -> None:
    """Write them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        'folder', type=Path, nargs='?', default=Path('light'), help='to write to (%(default)s)'
    )
    parser.add_argument(
        '--frames', type=int, default=FRAMES, metavar='N', help='how many (%(default)s)'
    )
    arguments = parser.parse_args()
    folder: Path = arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    scene = flashing_light(sigma=2.0, amplitude=150.0)
    for index in range(arguments.frames):
        cv2.imwrite(str(folder / f'frame_{index:04}.png'), scene.frame(index))
    print(f'{arguments.frames} frames in {folder}; now:')
    print(f'blob_tracker track {folder} --frame-rate 60 --field-of-view 56 --annotate')


if __name__ == '__main__':
    main()
