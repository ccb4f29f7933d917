"""A situation: frames with their truth, and what it would be right to say of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isfinite, nan

from blob_tracker.types import Pixels, SensorNoise
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
FULL_SCALE = 255  # DN
BACKGROUND = 30.0  # DN
SIGMA = 1.5  # px
PEAK = 120.0  # DN above the background
RATE = 60.0  # frames a second
WIDTH, HEIGHT = 128, 96  # px
SHAPE = (HEIGHT, WIDTH)
LARGE = (240, 320)  # px, height and width where much has to find room


@dataclass(frozen=True)
class Model:
    """
    What is expected in the pixels, as a function of what is unknown.

    Parameters
    ----------
    mean : callable
        (p,) parameters -> (..., h, w) DN: one image, or a stack of several.
    parameters : (p,) array
        Their true values; the place x, y (px) comes first.
    used : (..., h, w) bool array or None
        False where a pixel tells nothing: it is clipped, stuck or black.
    noise : SensorNoise
        Of the pixels.

    """

    mean: Callable[[Floats], Floats]
    parameters: Floats
    used: NDArray[np.bool_] | None = None
    noise: SensorNoise = NOISE


@dataclass(frozen=True)
class Shot:
    """
    One frame with its truth.

    Parameters
    ----------
    image : (h, w) array
        DN.
    on : bool
        Whether the light is on, and has to be found where it has a place.
    x, y : float
        Where the light shows in this frame, px; NaN where nothing of it does. A frame that is
        not `on` may show what is left of the light, and a bearing to it is no wrong one.
    also : (float, float) or None
        A second place that is as right: two lights that nothing tells apart.
    judged : bool
        False where no answer is right or wrong.
    model : Model or None
        Of the pixels that tell of the place; None if it cannot be written down.
    quantisation : (8, 8) array or None
        Steps of JPEG's coefficients, which a driver hands over with the picture.

    """

    image: Pixels
    on: bool
    x: float = nan
    y: float = nan
    also: tuple[float, float] | None = None
    judged: bool = True
    model: Model | None = None
    quantisation: NDArray[np.uint16] | None = None

    @property
    def lit(self) -> bool:
        """Whether the light has to be found."""
        return self.on and self.judged and isfinite(self.x)


Frames = Callable[[int, np.random.Generator], Iterator[Shot]]


@dataclass(frozen=True)
class Situation:
    """
    One kind of trouble at one strength.

    Parameters
    ----------
    number : int
        Of the row in the table of situations.
    kind : str
        What the trouble is.
    strength : str
        How much of it, with its unit.
    frames : callable
        (count, random) -> that many shots in the order of time, one each 1/60 s. It can be
        pickled.
    reason : str
        Regular expression of a reason that names the cause.
    noise : SensorNoise
        What the locator is told of the sensor.
    layout : str
        Of the pixels, see `Frame`.
    centred : bool
        True where the pulse has no middle by itself: its mean error is no error.

    """

    number: int
    kind: str
    strength: str
    frames: Frames
    reason: str
    noise: SensorNoise = NOISE
    layout: str = 'grey'
    centred: bool = False

    @property
    def name(self) -> str:
        """Kind and strength."""
        return f'{self.kind}, {self.strength}'
