#!/usr/bin/env python3
"""
Write the frames of a simulated light as PNG files, to try `blob_tracker track` on.

    python3 examples/simulated_frames.py light
    blob_tracker track light --frame-rate 60 --field-of-view 56 --annotate

The light is on in every other frame and goes round before a textured wall.
"""

from pathlib import Path
import sys

from blob_tracker.simulation import flashing_light
import cv2

FRAMES = 200  # at 60 frames/s


def main(folder: Path) -> None:
    """Write them."""
    folder.mkdir(parents=True, exist_ok=True)
    scene = flashing_light(sigma=2.0, amplitude=150.0)
    for index in range(FRAMES):
        cv2.imwrite(str(folder / f'frame_{index:04}.png'), scene.frame(index))
    print(f'{FRAMES} frames in {folder}; now:')
    print(f'blob_tracker track {folder} --frame-rate 60 --field-of-view 56 --annotate')


if __name__ == '__main__':
    main(Path(sys.argv[1] if len(sys.argv) > 1 else 'light'))
