"""A pulse that is learned while its light is tracked: used where it is better, and only there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from blob_tracker.location import EffectivePsf, Locator
from blob_tracker.location.locate import estimate
from blob_tracker.location.pulse_learner import COLLECTED, JUDGED, LAST, PulseLearner, WATCHED
from blob_tracker.types import Location, Window
import numpy as np
import pytest
from support.late_kernels import run_alone
from support.pulses import BACKGROUND, bound, drawn, NOISE, PEAK, Pulse, shots

SIDE = 9
LEARNING = 200  # flashes that it takes at most, with windows of this size


def moffat(width: float) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Return a profile with wings."""
    return lambda u, v: (1.0 + (u**2 + v**2) / width**2) ** -2.5


@cache
def sharp(width: float = 1.04) -> Pulse:
    """Return a pulse that is drawn into few pixels, of which a Gaussian is far from the bound."""
    return drawn(SIDE, moffat(width), 0.0)


@cache
def round_one() -> Pulse:
    """Return a Gaussian of 1.3 px."""
    return drawn(11, lambda u, v: np.exp(-(u**2 + v**2) / 2.42))


@cache
def disc() -> Pulse:
    """Return one out of focus, which other models are tried for."""
    return drawn(SIDE, lambda u, v: 1.0 / (1.0 + np.exp(3.0 * (np.hypot(u, v) - 2.5))))


@dataclass
class Flight:
    """What became of the flashes of a light that flies through all phases."""

    places: list[Location]
    errors: np.ndarray
    states: list[str]

    def since(self, state: str) -> int:
        """Return the flash after which the learner said so first."""
        return next(k for k, said in enumerate(self.states) if said.startswith(state)) + 1

    def nees(self, begin: int) -> float:
        """Return the mean square of the errors over their covariances."""
        inverse = np.linalg.inv([each.covariance for each in self.places[begin:]])
        errors = self.errors[begin:]
        return float(np.einsum('ni,nij,nj->n', errors, inverse, errors).mean())


def fly(
    light: Callable[[int], Pulse], count: int, seed: int, side: int = SIDE, learn: bool = True,
    pulse: EffectivePsf | None = None,
) -> tuple[Flight, Locator]:
    """Place a light flash by flash, as a node does."""
    random = np.random.default_rng(seed)
    locator = Locator(learn=learn, pulse=pulse)
    flight = Flight([], np.empty((0, 2)), [])
    errors = []
    for k in range(count):
        place = 100.0 + np.array([20.0 * np.sin(0.05 * k) + 3.0 * np.sin(0.37 * k),
                                  16.0 * np.cos(0.041 * k)])
        corner = np.rint(place).astype(int) - side // 2
        mean = BACKGROUND + PEAK * light(k)(*(place - corner))
        window = Window(
            shots(random, mean), shots(random, np.full(mean.shape, BACKGROUND)),
            int(corner[0]), int(corner[1]), k * 33_000_000, 1023,
        )
        location = locator.locate(window, noise=NOISE)
        locator.learn()
        flight.places.append(location)
        errors.append(np.array([location.x, location.y]) - place)
        flight.states.append(locator.learners[''].state if learn else '')
    flight.errors = np.array(errors)
    return flight, locator


@pytest.fixture(scope='module')
def learned() -> tuple[Flight, Locator]:
    """Return the flight of a sharp light, and what has learned it."""
    return fly(lambda k: sharp(), 1400, 1)


def test_a_light_that_is_no_gaussian_is_learned_and_placed_at_its_bound(
    learned: tuple[Flight, Locator]
) -> None:
    """With a true covariance before and after, and nearer to the bound after."""
    flight, locator = learned
    used = flight.since('learned from')
    assert COLLECTED + JUDGED < used < COLLECTED + LEARNING + JUDGED
    before, after = (
        np.sqrt(np.mean(part**2)) / bound(sharp(), SIDE)
        for part in (flight.errors[:used], flight.errors[used:])
    )
    # 900 flashes: their rms is known to 1.7 %.
    assert after < 1.1 * 1.04 < before * 1.04
    assert 1.4 < flight.nees(used) < 2.8
    result = locator.learners[''].learned
    assert result is not None and result.gain > 1.0


def test_the_same_flashes_are_placed_the_same(learned: tuple[Flight, Locator]) -> None:
    """However fast they come: nothing depends on the clock, nor on chance."""
    again, _ = fly(lambda k: sharp(), 600, 1)
    assert [each.x for each in again.places] == [each.x for each in learned[0].places[:600]]


def test_a_gaussian_stays_one_bit_for_bit() -> None:
    """The pulse that was learned is no likelier, and not used."""
    count = COLLECTED + LEARNING + JUDGED + 20
    flight, _ = fly(lambda k: round_one(), count, 2, 11)
    alone, _ = fly(lambda k: round_one(), count, 2, 11, learn=False)
    assert any('located as well without' in state for state in flight.states)
    for one, other in zip(flight.places, alone.places):
        assert (one.x, one.y, one.sigma) == (other.x, other.y, other.sigma)


def test_a_light_that_grows_and_shrinks_stays_right() -> None:
    """By a quarter to both sides: the scale is fitted, and the covariance holds."""
    sizes = np.linspace(0.8, 1.25, 15)

    def light(k: int) -> Pulse:
        return sharp(1.04 * sizes[int(round(7.0 + 7.0 * np.sin(2.0 * np.pi * k / 400.0)))])

    flight, locator = fly(light, 1300, 3)
    used = flight.since('learned from')
    pulse = locator.learners[''].pulse
    assert pulse is not None and pulse.varies
    assert 1.4 < flight.nees(used) < 2.8
    widest, narrowest = (
        np.median([each.sigma for k, each in enumerate(flight.places[800:1200]) if chosen(k)])
        for chosen in (lambda k: 60 < k < 140, lambda k: 260 < k < 340)
    )
    assert widest > 1.25 * narrowest


def test_a_pulse_that_fits_no_longer_is_dropped() -> None:
    """Another light: its places are right at once, and soon the pulse is forgotten."""
    change = COLLECTED + LEARNING + JUDGED
    wide = drawn(SIDE, lambda u, v: np.exp(-(u**2 + v**2) / 1.3), 0.3)
    flight, locator = fly(lambda k: sharp() if k < change else wide, change + 420, 4)
    assert flight.since('learned from') < change
    dropped = flight.since('the pulse that was learned does not fit any longer')
    # At worst as many as were better before have to be outweighed.
    assert change < dropped <= change + 2 * LAST * WATCHED
    assert locator.learners[''].pulse is None
    assert 1.4 < flight.nees(change) < 2.8


def test_the_centre_of_a_lopsided_light_stays_where_it_was() -> None:
    """What its centre is nobody can say: a bearing does not step as the pulse comes into use."""
    two = drawn(SIDE, lambda u, v: moffat(0.9)(u, v) + 0.5 * moffat(0.9)(u - 0.9, v - 0.3), 0.0)
    flight, _ = fly(lambda k: two, 1200, 5)
    used = flight.since('learned from')
    before, after = flight.errors[200:used], flight.errors[used:]
    error = np.hypot(before.std(axis=0) / np.sqrt(JUDGED), after.std(axis=0) / np.sqrt(len(after)))
    apart = np.abs(after.mean(axis=0) - before.mean(axis=0))
    # A median is known to 1.25 of a mean.
    assert (apart < 4.0 * 1.25 * error).all()


def test_what_cannot_be_learned_from_is_said() -> None:
    """A light that stands still, and the samples behind the filters of a mosaic."""
    learner = PulseLearner()
    random = np.random.default_rng(6)
    mean = BACKGROUND + PEAK * sharp()(4.2, 4.0)
    dark = np.full(mean.shape, BACKGROUND)
    for k in range(COLLECTED + 10):
        window = Window(shots(random, mean), shots(random, dark), stamp_ns=k * 33_000_000)
        found = estimate(window, method='maximum_likelihood', noise=NOISE)
        learner.take(window, NOISE, found, lambda: found)
        learner.work()
    assert 'not in all sub-pixel phases: let the target move' in learner.state
    assert learner.pulse is None
    sites = np.indices(mean.shape).sum(axis=0) % 2 == 0
    window = Window(shots(random, mean), shots(random, dark), sites=sites)
    learner.take(window, NOISE, found, lambda: found)
    learner.work()
    assert 'colour mosaic' in learner.state


def test_only_maximum_likelihood_learns() -> None:
    """The others say so."""
    with pytest.raises(ValueError, match="'centroid' takes no learned pulse"):
        Locator('centroid', learn=True)


LEARNED_OR_GIVEN = """
from blob_tracker.location import compile_ahead, EffectivePsf, Locator
from location.test_pulse_learner import COLLECTED, disc, fly, LEARNING, sharp
from support.late_kernels import late_kernels
import numpy as np

compile_ahead(['maximum_likelihood'])
bell = np.exp(-0.5 * (np.arange(-12, 13) * 0.5 / 1.3) ** 2)
given = None if {learn} else EffectivePsf(np.outer(bell, bell) * 1.05, 0.5, 1.3)
Locator(learn={learn}, pulse=given)  # as one that a node makes before there is a light
late = late_kernels()
flight, _ = fly(
    # Judged on windows that other models are tried for too.
    lambda k: sharp() if k < COLLECTED else disc(), COLLECTED + LEARNING if {learn} else 4, 1,
    learn={learn}, pulse=given)
assert not late, late
assert not {learn} or any(said.startswith('judging') for said in flight.states)
"""


@pytest.mark.parametrize('learn', [True, False])
def test_nothing_is_left_to_compile_for_a_pulse(learn: bool) -> None:
    """Neither for one that is learned, judged and used, nor for one that is given."""
    run_alone(LEARNED_OR_GIVEN.format(learn=learn))
