"""Lights that blink and move: where they are and when they are on, exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from blob_tracker.blinking.patterns import code, Pattern, wave
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WIDTH, HEIGHT = 752, 480  # px
RATE = 60.0  # frames a second
EXPOSURE = 0.5 / RATE  # s
FREE_RATE = 59.7  # bits a second of lights that run free
FREQUENCIES = (6.0, 10.0, 13.7)  # Hz
SAMPLES = 64  # of an exposure
REACH = (60.0, 150.0)  # px from the middle of a path, along each axis
TURN_FRAMES = 40.0  # between two turns, in the mean
MARGIN = 20.0  # px from the border of the picture


@dataclass(frozen=True)
class Light:
    """
    A light.

    Parameters
    ----------
    pattern : Pattern
        As the tracker knows it.
    phase : float
        Of its period, at the time 0.
    rate_error : float
        Of its clock, as a part.
    path : Path
        Where it is.

    """

    pattern: Pattern
    phase: float
    rate_error: float
    path: Path

    def on(self, times: Floats) -> NDArray[np.bool_]:
        """Return when it is on."""
        part = (times * (1.0 + self.rate_error) / self.pattern.period + self.phase) % 1.0
        edges = self.pattern.edges
        return np.any(
            [(begin <= part + k) & (part + k < end) for begin, end in edges for k in (0, 1)],
            axis=0,
        )


class Path:
    """Places over time."""

    def at(self, times: Floats) -> Floats:
        """Return (..., 2) px."""
        raise NotImplementedError


class Sinusoid(Path):
    """A smooth path whose speed is at most that asked for, px a frame."""

    def __init__(self, speed: float, random: np.random.Generator) -> None:
        self.reach = random.uniform(*REACH, 2)
        room = np.array([WIDTH, HEIGHT]) / 2 - self.reach - MARGIN
        self.middle = np.array([WIDTH, HEIGHT]) / 2 + random.uniform(-1, 1, 2) * room
        self.phase = random.uniform(0.0, 2 * np.pi, 2)
        direction = random.uniform(0.2, 0.5 * np.pi - 0.2)
        top = speed * RATE * np.array([np.cos(direction), np.sin(direction)])
        self.omega = top / self.reach

    def at(self, times: Floats) -> Floats:
        angle = np.multiply.outer(times, self.omega) + self.phase
        return np.asarray(self.middle + self.reach * np.sin(angle))


class Turning(Path):
    """A constant speed whose direction changes now and then, and at the border."""

    def __init__(self, speed: float, random: np.random.Generator, duration: float) -> None:
        place = random.uniform([MARGIN, MARGIN], [WIDTH - MARGIN, HEIGHT - MARGIN])
        time = -1.0 / RATE
        self.knots, self.places = [time], [place]
        while time < duration:
            length = max(random.exponential(TURN_FRAMES), 6.0) / RATE
            for _ in range(100):
                angle = random.uniform(0.0, 2 * np.pi)
                there = place + speed * RATE * length * np.array([np.cos(angle), np.sin(angle)])
                if np.all((there > MARGIN) & (there < [WIDTH - MARGIN, HEIGHT - MARGIN])):
                    break
            else:
                length *= 0.5
                there = place
                continue
            time, place = time + length, there
            self.knots.append(time)
            self.places.append(place)

    def at(self, times: Floats) -> Floats:
        places = np.array(self.places)
        return np.stack([np.interp(times, self.knots, places[:, k]) for k in range(2)], axis=-1)


def codes(count: int, length: int) -> list[str]:
    """
    Return so many codes that differ in every phase, half lit and never dark for long.

    By trial in the order of the numbers: any two differ in as many bits as can be had, 4 to begin
    with, and no more than three zeros follow each other.
    """
    for distance in (4, 3, 2, 1):
        found: list[NDArray[np.int64]] = []
        for number in range(2**length):
            bits = np.array([number >> k & 1 for k in range(length)])
            text = ''.join(map(str, bits))
            if '0000' in 2 * text or not 0.4 * length <= bits.sum() <= 0.65 * length:
                continue
            turned = [np.roll(bits, k) for k in range(length)]
            own = min(int((each != bits).sum()) for each in turned[1:])
            if own >= 2 and all(
                min(int((each != other).sum()) for each in turned) >= distance for other in found
            ):
                found.append(bits)
                if len(found) == count:
                    return [''.join(map(str, each)) for each in found]
    raise ValueError(f'there are no {count} codes of {length} bits')


def patterns(timing: str, count: int, length: int = 10) -> list[Pattern]:
    """Return the patterns of so many lights: 'in step', 'free' or 'waves'."""
    if timing == 'waves':
        return [wave(f'w{k}', frequency, 0.5) for k, frequency in enumerate(FREQUENCIES[:count])]
    rate = RATE if timing == 'in step' else FREE_RATE
    return [code(f'c{k}', bits, rate) for k, bits in enumerate(codes(count, length))]


def lights(
    timing: str, known: Sequence[Pattern], speed: float, turns: bool, duration: float,
    random: np.random.Generator, rate_error: float = 0.0,
) -> list[Light]:
    """Return a light for each pattern."""
    found = []
    for pattern in known:
        path = Turning(speed, random, duration) if turns else Sinusoid(speed, random)
        phase = random.uniform()
        if timing == 'in step':
            # Bits change in the middle between two exposures.
            bits = round(pattern.period * RATE)
            phase = (np.floor(phase * bits) + 0.5) / bits
        found.append(Light(pattern, phase, rate_error * random.choice([-1.0, 1.0]), path))
    return found


@dataclass(frozen=True)
class Truth:
    """
    What a frame sees of a light.

    Parameters
    ----------
    share : float
        Part of the exposure for which it is on.
    tau : float
        Middle of that part from the middle of the exposure, s.
    x, y : float
        Centroid of its light, px.
    covariance : (2, 2) array
        Of the places it is at meanwhile: its streak, px^2.

    """

    share: float
    tau: float
    x: float
    y: float
    covariance: Floats


def truth(light: Light, time: float) -> Truth | None:
    """Return what an exposure about a time sees of a light; None if it is dark."""
    offsets = ((np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5) * EXPOSURE
    on = light.on(time + offsets)
    if not on.any():
        return None
    places = light.path.at(time + offsets[on])
    middle = places.mean(axis=0)
    away = places - middle
    return Truth(
        float(on.mean()), float(offsets[on].mean()), middle[0], middle[1],
        away.T @ away / len(away),
    )
