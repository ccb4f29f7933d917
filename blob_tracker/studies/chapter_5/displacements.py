"""The experiment of chapter 5 in the virtual lab: a camera on a stage, a target, eleven places."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.location import locate
from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.location.multi_gaussian import LAMP_AMPLITUDES, LAMP_WIDTHS
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.thresholds import threshold_by_name
from blob_tracker.simulation import expose
from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.simulation.profiles import Gaussian, ThreeGaussians
from blob_tracker.simulation.trailing_edge import MEMORY_PX, PEAKING
from blob_tracker.studies.printed import load
from blob_tracker.types import Frame, LocationError, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

PLACES, LOOKS = 11, 5  # thesis, page 104
SIDE = 56  # px: cropped to 50 to 60 (page 106)
BRIGHTEST = 240.0  # DN: below 250 (page 105), with room for the noise
MIDDLE = (320.0, 240.0)  # px: the box is in the middle of the picture (page 98)
PX_PER_MRAD = 1.0 / 1.67  # of the 6 mm lens (Table 2.1, page 12)
STEPS = ('0.05', '0.10', '1.00')  # px, in the order of the tables
SEGMENTATIONS = {
    'otsu_window': 'Shio & Otsu',
    'histogram': 'Histogram',
    'histogram_extended': 'Extended Histogram',
    'histogram_shortened': 'Shortened Histogram',
}
WHOLE, CROP = 'whole', Box(0, 0, SIDE, SIDE)  # no segmentation at all
NOISE = SensorNoise(gain=np.inf, read_noise=1.0)  # thesis, section 2.2.3


@dataclass(frozen=True)
class Target:
    """A target: its shape, its sigma in px, and the level about it in DN."""

    profile: Gaussian | ThreeGaussians
    sigma: float
    background: float

    @property
    def amplitudes(self) -> NDArray[np.float64]:
        """Peaks of its round Gaussians, in parts of its own."""
        if isinstance(self.profile, Gaussian):
            return np.ones(1)
        return np.array(LAMP_AMPLITUDES) / sum(LAMP_AMPLITUDES)

    @property
    def sigmas(self) -> NDArray[np.float64]:
        """Their standard deviations, px."""
        if isinstance(self.profile, Gaussian):
            return np.array([self.sigma])
        return self.sigma * np.array(LAMP_WIDTHS)


# 10 px wide, as page 102 has it: the printed Gaussian at 2 sigma to either side on lit paper, the
# lamp's blob (three Gaussians, section 4.3.2) with a base s of 2 px, in the dark.
TARGETS = {
    'passive': Target(Gaussian(), 2.5, 40.0),
    'active': Target(ThreeGaussians(), 2.0 / sqrt(2.0), 10.0),
}


@dataclass(frozen=True)
class Conditions:
    """
    What the experiment suffers from; as it stands only from what no camera is without.

    Parameters
    ----------
    noise : SensorNoise or None
        Of the grabbed pixel: 1 DN rms by default (thesis, section 2.2.3). None is a converter
        without noise or steps.
    chain : AnalogueChain
        The camera and the grabber.
    caliper : float
        Error of the stage's place, rms, inches.
    turn : float
        Angle by which the camera turns at each setting of the stage, rms, mrad.
    tremble : float
        Movement of the picture from look to look, rms, px.

    """

    noise: SensorNoise | None = NOISE
    chain: AnalogueChain = AnalogueChain()
    caliper: float = 0.0
    turn: float = 0.0
    tremble: float = 0.0


LABORATORY = Conditions(
    chain=AnalogueChain(
        drift=1.0, between_fields=0.02, per_line=0.05, own_clock=True,
        trailing_edge=TrailingEdge(PEAKING, MEMORY_PX),
    ),
    caliper=0.001,
)


@dataclass(frozen=True)
class Sequence:
    """
    The pictures of one trial.

    Parameters
    ----------
    asked, truth : (11,) arrays
        x that the displacement asks for and that the light has, px of the picture.
    y : float
        px.
    looks : (11, 5, h, w) array
        The crops, DN.
    corner : (int, int)
        Column and row of their first pixel.
    amplitude : float
        Peak of the light above its background ahead of the camera's filter, DN.

    """

    asked: NDArray[np.float64]
    truth: NDArray[np.float64]
    y: float
    looks: NDArray[Any]
    corner: tuple[int, int]
    amplitude: float


def inches_per_pixel(step: str) -> float:
    """Return the calibrated displacement of one pixel for trials of this step (Table 5.1)."""
    for row in load('table_5_1').rows:
        if row[1] == step:
            return float(row[2]) / float(row[1])
    raise ValueError(f'no trial has steps of {step} px; there are {", ".join(STEPS)}')


def brightness(target: Target, conditions: Conditions) -> float:
    """Return the amplitude, DN, with which the brightest pixel is at BRIGHTEST: the aperture."""
    shape, corner = (SIDE, SIDE), (int(MIDDLE[0]) - SIDE // 2, int(MIDDLE[1]) - SIDE // 2)
    chain = replace(conditions.chain, per_line=0.0, per_frame=0.0)
    random = np.random.default_rng(0)
    unit = chain.window(
        shape, corner, *MIDDLE, target.profile, target.sigma, 1.0, 0.0, random
    ).max()
    return (BRIGHTEST - target.background) / float(unit)


def draw(
    target: Target, step: str, conditions: Conditions, seed: int, *, lit: bool = True
) -> Sequence:
    """
    Take five looks at each of eleven places.

    Parameters
    ----------
    target : Target
        What is looked at.
    step : str
        Displacement between places, px, as printed.
    conditions : Conditions
        What the experiment suffers from.
    seed : int
        Of the place where it begins, and of all noise.
    lit : bool
        False for the same places with the lamp off.

    """
    random = np.random.default_rng([seed, STEPS.index(step)])
    pitch = float(step)
    start = np.array(MIDDLE) + random.uniform(-0.5, 0.5, 2) - [pitch * (PLACES - 1) / 2.0, 0.0]
    asked = start[0] + pitch * np.arange(PLACES)
    place = asked + conditions.caliper / inches_per_pixel(step) * random.standard_normal(PLACES)
    place = place + conditions.turn * PX_PER_MRAD * random.standard_normal(PLACES)
    corner = (int(MIDDLE[0]) - SIDE // 2, int(MIDDLE[1]) - SIDE // 2)
    amplitude = brightness(target, conditions)
    noise = np.random.default_rng([seed, STEPS.index(step), int(lit)])
    kind = np.float64 if conditions.noise is None else np.uint8
    looks = np.empty((PLACES, LOOKS, SIDE, SIDE), kind)
    for index in range(PLACES):
        for look in range(LOOKS):
            x = place[index] + conditions.tremble * noise.standard_normal()
            mean = conditions.chain.window(
                (SIDE, SIDE), corner, x, start[1], target.profile, target.sigma,
                amplitude if lit else 0.0, target.background, noise,
            )
            looks[index, look] = (
                np.clip(mean, 0.0, 255.0) if conditions.noise is None
                else expose(mean, conditions.noise, noise)
            )
    chain = conditions.chain
    return Sequence(
        chain.seen_at(asked), chain.seen_at(place), float(start[1]), looks, corner, amplitude
    )


def segmented(picture: NDArray[np.floating], name: str) -> Box | None:
    """
    Return the blob's box in a crop by one of the thesis' segmentations (section 5.3).

    The crop is taken as it is: "pure" data, without its background taken off (page 99).
    """
    lit = np.rint(picture).astype(np.uint8)
    row, column = (int(index) for index in np.unravel_index(np.argmax(lit), lit.shape))
    nothing = dict.fromkeys(Candidate._fields, 0.0) | {'rejected': ''}
    candidate = Candidate(
        **{**nothing, 'column': float(column), 'row': float(row), 'noise': 1.0}  # type: ignore
    )
    contrast = Contrast(lit, np.zeros_like(lit), 255, Frame(lit, 0, 255), (lit,), ())
    find = threshold_by_name(name, sigmas=3.0, extension=2)
    return find(contrast, candidate, SIDE // 2)


def placed(
    sequence: Sequence,
    segmentation: str,
    method: str,
    *,
    averaged: bool,
    removed: bool,
    elliptical: bool = False,
    held: bool = False,
) -> NDArray[np.float64]:
    """
    Return the (11,) x that a method finds; NaN where it finds none.

    Parameters
    ----------
    sequence : Sequence
        The pictures.
    segmentation, method : str
        Keys of `THRESHOLDS`, or WHOLE, and of `METHODS`.
    averaged : bool
        Of the mean of five looks; else of the first one.
    removed : bool
        With the background, the median of the crop's border, taken off ahead of locating; else
        as the thesis does, from the light and what is below it together.
    elliptical : bool
        Passed on, where it is True.
    held : bool
        Whether the window of the first place is kept for all of them.

    """
    found = np.full(PLACES, np.nan)
    options = {'elliptical': True} if elliptical else {}
    first: Box | None = None
    for index, looks in enumerate(sequence.looks):
        picture = looks.mean(axis=0) if averaged else looks[0].astype(float)
        box = first or (
            CROP if segmentation == WHOLE else segmented(picture, segmentation)
        )
        if box is None:
            continue
        first = box if held else None
        level = border_median(picture) if removed else 0.0
        part = picture[box.slices]
        window = Window(part, np.full_like(part, level), box.x0, box.y0)
        try:
            found[index] = locate(window, method=method, noise=NOISE, **options).x
        except LocationError:
            continue
    return found + sequence.corner[0]


def bound(target: Target, looks: int, *, unlit: bool = False) -> float:
    """
    Return the Cramer-Rao bound of x, rms px, in the whole crop and without defects.

    It is that of 1 DN of noise and the rounding, amplitudes and widths unknown, as the mean over
    places within a pixel. They and the background are even about the place, x is odd: whether
    they are known makes no difference to it.

    Parameters
    ----------
    target : Target
        What is looked at.
    looks : int
        Pictures of which the mean is taken.
    unlit : bool
        Of lit minus unlit: pixel by pixel, with the noise of both.

    """
    amplitude = brightness(target, Conditions())
    floor = (NOISE.read_noise**2 + 1.0 / 12.0) / looks  # of the mean of the looks
    noise = replace(NOISE, read_noise=float(np.sqrt(max(floor - 1.0 / 12.0, 0.0))))
    middle = (SIDE - 1) / 2.0
    variances = [
        cramer_rao_bound(
            (SIDE, SIDE), x=middle + phase, y=middle, sigma=target.sigmas,
            amplitude=amplitude * target.amplitudes, background=target.background, noise=noise,
            unlit=unlit,
        )[0, 0]
        for phase in (0.0, 0.25, 0.5)
    ]
    return float(np.sqrt(np.mean(variances)))


def border_median(picture: NDArray[np.floating]) -> float:
    """Return the median of the outermost pixels, DN."""
    border = [picture[0], picture[-1], picture[:, 0], picture[:, -1]]
    return float(np.median(np.concatenate(border)))


def figures_of(
    found: NDArray[np.float64], truth: NDArray[np.float64]
) -> dict[str, float | int | None]:
    """
    Return what a sequence comes to.

    `mean` and `variance` are those of the ten steps, as the thesis gives them (section 5.5);
    `rms` is that of the places against the truth, `apart` after their common offset is taken off;
    `worst` the largest of these; `lost` how many places were not found. None if too few were.
    """
    steps = np.diff(found)
    steps = steps[np.isfinite(steps)]
    error = (found - truth)[np.isfinite(found)]
    lost = int(np.count_nonzero(~np.isfinite(found)))
    if steps.size < 2:
        return {'mean': None, 'variance': None, 'rms': None, 'apart': None, 'worst': None,
                'lost': lost}
    about = error - error.mean()
    return {
        'mean': float(steps.mean()),
        'variance': float(steps.var(ddof=1)),
        'rms': float(np.sqrt(np.mean(error**2))),
        'apart': float(np.sqrt(np.mean(about**2))),
        'worst': float(np.abs(about).max()),
        'lost': lost,
    }
