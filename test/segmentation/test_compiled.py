"""After `compile_ahead` no frame waits for a compiler."""

from __future__ import annotations

from support.late_kernels import run_alone

SCENES = """
import numpy as np
from blob_tracker.pipeline import compile_ahead
from blob_tracker.segmentation import Expectation, flash_by_name, Segmenter
from blob_tracker.segmentation.in_step import InStep
from blob_tracker.types import Frame
from support.late_kernels import late_kernels

compile_ahead(['maximum_likelihood'])
late = late_kernels()
random = np.random.default_rng(1)
y, x = np.indices((96, 128))


def blob(column, row, height):
    return height * np.exp(-0.5 * ((x - column) ** 2 + (y - row) ** 2) / 2.0)


for kind, full in ((np.uint8, 255), (np.uint16, 4095)):
    for lights in (1, 2, 40):
        flash = InStep()
        segmenter = Segmenter(flash=flash)
        for index in range(40):
            scene = np.full(x.shape, 20.0)
            if index % 2 == 0 and not 20 <= index < 30:
                scene += blob(60.0 + 0.2 * index, 40.0, 100.0)
            if lights == 2 and index % 2 == 0:
                scene += blob(20.0, 70.0, 60.0)
            for _ in range(lights if lights > 2 else 0):
                scene += blob(random.uniform(5, 120), random.uniform(5, 90), 80.0)
            image = np.clip(random.normal(scene, 1.0), 0, full).astype(kind)
            image.flags.writeable = index % 5 > 0
            flash.agree_with(Expectation(62.0, 40.0, np.eye(2)) if index % 7 == 0 else None)
            expected = Expectation(60.0 + 0.2 * index, 40.0, np.eye(2)) if index % 3 else None
            segmenter.update(Frame(image, 10**9 + index * 16_666_667, full), expected)

segmenter = Segmenter(flash=flash_by_name('steady'))
for index in range(4):
    scene = 20.0 + blob(60.0, 40.0, 100.0) + blob(20.0, 70.0, 400.0)
    image = np.clip(random.normal(scene, 1.0), 0, 255).astype(np.uint8)
    segmenter.update(Frame(image, 10**9 + index * 16_666_667, 255))

segmenter = Segmenter(flash=flash_by_name('auto'))  # a second of trying, three of watching
for index in range(280):
    scene = 20.0 + blob(60.0, 40.0, 100.0) * (index % 3 == 0)
    image = np.clip(random.normal(scene, 1.0), 0, 255).astype(np.uint8)
    segmenter.update(Frame(image, 10**9 + index * 16_666_667, 255))
assert not late, late
"""


def test_compile_ahead_leaves_nothing_to_compile() -> None:
    """For lights, glints and all that is told of them, of 8 and of 16 bits: in a process alone."""
    run_alone(SCENES)


MOVED = """
import numpy as np
from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.types import Frame
from support.late_kernels import late_kernels

segmenters = [Segmenter(flash=Alternate(registration=each)) for each in ('affine', 'translation')]
late = late_kernels()
texture = np.random.default_rng(1).integers(20, 60, (120, 160)).astype(np.uint8)
for index in range(8):
    image = np.roll(texture, index, axis=1)
    for segmenter in segmenters:
        segmenter.update(Frame(image, 10**9 + index * 16_666_667, 255))
waited = [each for each in late if '.registration.' in each]
assert not waited, waited
"""


def test_a_registration_is_compiled_when_it_is_chosen() -> None:
    """Few need it: it is loaded by who asks for it, and not in the midst of tracking."""
    run_alone(MOVED)
