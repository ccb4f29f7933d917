"""An interlaced camera: every second line of a scene at a time, woven into pictures."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.capture.fields import ORDERS
from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.simulation.noise_bank import NoiseBank
from blob_tracker.simulation.scene import Scene
from blob_tracker.types import Frame, Pixels
import numpy as np


@dataclass(frozen=True)
class InterlacedCamera:
    """
    What a grabber gives of an analogue camera that looks at a scene.

    Line u of a field is the mean of the scene's lines o + 2 u and o + 2 u + 1, as of a camera that
    integrates fields: o is 0 at the top and 1 at the bottom. The last line of the bottom, which
    has no other below it, is the scene's last line alone.

    Parameters
    ----------
    scene : Scene
        Its frames are the fields, in the order of time, and its rate is that of the fields. Frames
        2 n and 2 n + 1 make picture n.
    order : str
        'interlaced_tb' or 'interlaced_bt': which field of a picture is taken first.
    chain : AnalogueChain
        What happens to the lines on their way.

    Raises
    ------
    ValueError
        If there is no such order.

    Examples
    --------
    Sixty fields a second, of which the bottom one comes first:

    >>> camera = InterlacedCamera(Scene(width=160, height=120, rate=60.0), order='interlaced_bt')
    >>> camera.picture(0).image.shape, camera.interval_ns  # -, ns
    ((120, 160), 33333333)

    """

    scene: Scene
    order: str = 'interlaced_tb'
    chain: AnalogueChain = AnalogueChain()

    def __post_init__(self) -> None:
        if not self.order.startswith('interlaced_') or self.order not in ORDERS:
            raise ValueError(f"the order is '{self.order}'; it is interlaced_tb or interlaced_bt")

    @property
    def interval_ns(self) -> int:
        """From picture to picture, ns."""
        return round(2e9 / self.scene.rate)

    def picture(self, index: int) -> Frame:
        """Return a picture; its stamp is that of the field which was taken first."""
        scene = self.scene
        deep = scene.sensor.bits > 8
        image = np.empty((scene.height, scene.width), np.uint16 if deep else np.uint8)
        for later, kind in enumerate(ORDERS[self.order][0]):
            image[kind::2] = self._field(2 * index + later, kind)
        return Frame(
            image, scene.stamp_ns(2 * index), scene.sensor.saturation,
            exposure_ns=round(1e9 * scene.exposure / scene.rate),
        )

    def _field(self, index: int, kind: int) -> Pixels:
        """Return the lines of a field, top (0) or bottom (1)."""
        scene = self.scene
        mean = scene.mean(index)
        below = np.minimum(np.arange(len(mean)) + 1, len(mean) - 1)
        lines = 0.5 * (mean + mean[below])[kind::2]
        random = np.random.Generator(np.random.SFC64([scene.seed, index, 2]))
        return scene.sensor.expose(
            self.chain.field(lines, kind, random), NoiseBank(scene.seed, index))
