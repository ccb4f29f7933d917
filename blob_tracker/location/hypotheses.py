"""One window, what may be true of it, and the choice between the models that were fitted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import functools
import math

from blob_tracker.location.estimates import Beside, Failure
from blob_tracker.location.noise import variance_at
from blob_tracker.location.texture_field import log_likelihood_of_texture
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

# Twice the gain in log-likelihood that as many more parameters make of noise once in 1e4:
# chi-square, and a straight line to within 0.4 of it up to eight.
FALSE_ALARM = (12.8, 2.7)
UNHEARD = -5.0  # log weight of a model in a flash that did not speak for it, but for another one
LEAST_BELIEF = -10.0
TWO_LIGHTS = 'two_lights'  # the model that has a second light
SWITCHED = 'switched'  # the one whose rows are cut


@dataclass(frozen=True)
class Motion:
    """
    What the last places of a light say of its motion.

    Parameters
    ----------
    flash : (2,) array
        Displacement from the last lit frame to this one, window px.
    deviation : float
        Its standard deviation along either axis, px.
    place : (2,) array or None
        Where it should be now, window px.

    """

    flash: NDArray[np.float64]
    deviation: float
    place: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Way:
    """
    How far the light of a window moves while it is exposed, as a tracker knows it.

    Parameters
    ----------
    length : (2,) array
        Displacement, window px.
    deviation : float
        Its standard deviation along either axis, px.
    bend : (2,) array
        What the path's ends lie off a straight one through its middle, px.

    """

    length: NDArray[np.float64]
    deviation: float
    bend: NDArray[np.float64]


@dataclass(frozen=True)
class History:
    """
    What the last flashes of a light say of the next.

    Parameters
    ----------
    motion : Motion or None
        None if nothing is known of it.
    even : bool
        Whether the light leant to no side in the sum of them.
    evidence : sequence of mappings
        Of each flash in which alternatives were heard: their log weights less that of the best, by
        their names.
    beside : Beside or None
        The second light that flashed with it.
    last : (2,) array or None
        Where it was in the last flash, window px; None if that is not known.

    """

    motion: Motion | None = None
    even: bool = False
    evidence: Sequence[Mapping[str, float]] = ()
    beside: Beside | None = None
    last: NDArray[np.float64] | None = None

    def belief(self, model: str, rarity: float = 0.0) -> float:
        """
        Return the log weight of a model beforehand.

        It is the sum of those of the last flashes, less that of the model that was the likeliest
        over all of them, and less its rarity: that one is rare once, not in each flash, and what
        it was ahead by has paid for it. A light may become another one: what its pixels
        themselves say by more than LEAST_BELIEF outdoes it.
        """
        ahead = self._ahead(model)
        if ahead <= 0.0:
            return max(ahead, LEAST_BELIEF) - rarity
        return min(max(ahead + LEAST_BELIEF, 0.0), -LEAST_BELIEF, rarity) - rarity

    def is_certain(self, model: str) -> bool:
        """Tell whether the last flashes speak for one model alone."""
        return self._ahead(model) > -LEAST_BELIEF

    def _ahead(self, model: str) -> float:
        """Return by how much of the log weight the last flashes speak for a model."""
        names = {name for each in self.evidence for name in each} | {model}
        totals = {
            name: sum(each.get(name, UNHEARD) for each in self.evidence) for name in names
        }
        own = totals.pop(model)
        return own - max(totals.values(), default=own)


UNKNOWN = History()


@dataclass(frozen=True)
class Pair:
    """
    The pixels of one window.

    Parameters
    ----------
    lit : (h, w) array
        DN.
    unlit : (h, w) array or None
        DN; None if there is no unlit window.
    noise : SensorNoise
        Of a pixel, its black level taken off already.
    saturation : float
        The DN at which a pixel is clipped; infinite where none can be.
    history : History
        Of the light.
    way : Way or None
        None if it is not known.
    pitch : int
        px of the sensor's picture along either side of one of these, as `coarse` has them.
    sites : (h, w) bool array or None
        Which pixels see the light; None if all do. The others are no samples, and hold the
        mean of their neighbours.
    haunted : bool
        Whether there is more in the unlit window than noise: a light, or a texture.

    """

    lit: NDArray[np.float64]
    unlit: NDArray[np.float64] | None
    noise: SensorNoise
    saturation: float
    history: History = UNKNOWN
    way: Way | None = None
    pitch: int = 1
    sites: NDArray[np.bool_] | None = None
    haunted: bool = False

    @property
    def motion(self) -> Motion | None:
        """Return what is known of the light's motion."""
        return self.history.motion

    @functools.cached_property
    def usable(self) -> NDArray[np.bool_]:
        """(k, h, w) bool, k 1 or 2: the lit and the unlit samples that are not clipped."""
        below = self.pixels < self.saturation
        return below if self.sites is None else below & self.sites

    @functools.cached_property
    def clipped(self) -> int:
        """Return how many of the lit samples are clipped."""
        clipped = self.lit >= self.saturation
        return int(np.count_nonzero(clipped if self.sites is None else clipped & self.sites))

    @functools.cached_property
    def lattice(self) -> tuple[slice, slice]:
        """Return which rows and columns are samples, of a mosaic every other one."""
        if self.sites is None:
            return slice(None), slice(None)
        row, column = np.argwhere(self.sites)[0]
        return slice(row, None, 2), slice(column, None, 2)

    @functools.cached_property
    def pixels(self) -> NDArray[np.float64]:
        """(k, h, w) array, k 1 or 2: the lit pixels and, where there are, the unlit ones."""
        return self.lit[None] if self.unlit is None else np.stack([self.lit, self.unlit])

    @functools.cached_property
    def unlit_variance(self) -> float:
        """Return the variance of an unlit pixel at the window's mean, DN^2."""
        assert self.unlit is not None
        return variance_at(float(self.unlit.sum()) / self.unlit.size, self.noise)

    @functools.cached_property
    def log_likelihood_of_texture(self) -> float:
        """Return that of the unlit window if it holds a random texture."""
        assert self.unlit is not None
        return log_likelihood_of_texture(self.unlit[self.lattice], self.unlit_variance)


@dataclass(frozen=True)
class Fit:
    """
    A model that was fitted to a pair.

    Parameters
    ----------
    x, y : float
        px, from the centre of the window's first pixel.
    covariance : (2, 2) array
        px^2, order x, y.
    amplitude, background, sigma, snr, chi2 : float
        As in `Location`.
    log_likelihood : float
        Of all pixels of the pair, as `pair_likelihood` has it.
    parameters : int
        How many were fitted.
    warning : str
        What the user should know and do; '' where there is nothing.
    failure : Failure
        Why the window has no location although its model is known; NONE where it has one.
    misfit : bool
        Whether the pixels show that the model is not the true one.
    model : str
        Name of the alternative; '' of one round pulse.
    rarity : float
        By how much of the log-likelihood it is rarer beforehand than others.
    lopsided : bool
        Whether the light is to one side of the place.
    evidence : mapping of str to float
        Of the models that were heard: their log weights by these pixels, less that of the best.
    beside : Beside or None
        The second light, of a model that has one.
    way : (2,) array or None
        From one end to the other, px, of a light that draws a streak.
    drawn : float
        By how much lower it is than the round pulse, px, of a light whose rows are cut.

    """

    x: float
    y: float
    covariance: NDArray[np.float64]
    amplitude: float
    background: float
    sigma: float
    snr: float
    chi2: float
    log_likelihood: float
    parameters: int
    warning: str = ''
    failure: Failure = Failure.NONE
    misfit: bool = False
    model: str = ''
    rarity: float = 0.0
    lopsided: bool = False
    evidence: Mapping[str, float] = field(default_factory=dict)
    beside: Beside | None = None
    way: NDArray[np.float64] | None = None
    drawn: float = 0.0


def least_gain(parameters: int, rarity: float) -> float:
    """
    Return the gain from which on an alternative is heard, twice in log-likelihood.

    Parameters
    ----------
    parameters : int
        How many more it has than the base.
    rarity : float
        By how much of the log-likelihood it is rarer beforehand.

    """
    fixed, each = FALSE_ALARM
    return fixed + each * max(parameters, 0) + 2.0 * rarity


def is_heard(base: Fit, log_likelihood: float, parameters: int, rarity: float) -> bool:
    """Tell whether a model of such a likelihood is heard beside the base, see `least_gain`."""
    gain = 2.0 * (log_likelihood - base.log_likelihood)
    return gain > least_gain(parameters - base.parameters, rarity)


def choose(
    base: Fit, alternatives: Iterable[Fit], pixels: int, history: History = UNKNOWN
) -> Fit:
    """
    Return the model that the pixels speak for.

    An alternative is heard where its likelihood ratio over the base is one that noise makes
    less than once in 1e4. Those that are heard have the weights exp(-BIC / 2) with the
    Bayesian information criterion BIC = k ln n - 2 ln L (Schwarz, 1978), times those that they had
    in the last flashes, over how rare they are. The best of them is returned,
    at the mean of their places; its covariance holds how far apart they are (Hoeting et al.,
    Bayesian model averaging, Statistical Science 14 (1999), eq. 3 and 4).

    Parameters
    ----------
    base : Fit
        The model that holds until another is shown to.
    alternatives : iterable of Fit
        The others.
    pixels : int
        n, of the pair.
    history : History
        What the last flashes were.

    """
    heard = [
        fit for fit in alternatives
        if is_heard(base, fit.log_likelihood, fit.parameters, fit.rarity)
    ]
    if not heard:
        return base
    values = np.array([
        fit.log_likelihood - 0.5 * fit.parameters * math.log(pixels)
        + history.belief(fit.model, fit.rarity)
        for fit in heard
    ])
    # What one flash adds to many is its likelihood, less what a parameter gains from noise
    # (Akaike, IEEE Trans. Automatic Control 19 (1974), eq. 16): what is rare is so once, not in
    # each of them.
    told = np.array([fit.log_likelihood - fit.parameters for fit in heard])
    evidence = {fit.model: float(value) for fit, value in zip(heard, told - told.max())}
    best = _with_hidden_light(replace(heard[int(values.argmax())], evidence=evidence), history)
    placed = np.array([fit.failure == Failure.NONE for fit in heard])
    if best.failure != Failure.NONE or placed.sum() < 2:
        return best
    weights = np.where(placed, np.exp(values - values.max()), 0.0)
    weights /= weights.sum()
    places = np.array([(fit.x, fit.y) for fit in heard])
    mean = weights @ places
    apart = places - mean
    covariance = np.einsum('n,ni,nj->ij', weights, apart, apart)
    covariance += sum(weight * fit.covariance for weight, fit in zip(weights, heard))
    return replace(best, x=float(mean[0]), y=float(mean[1]), covariance=covariance)


def _with_hidden_light(fit: Fit, history: History) -> Fit:
    """Return a fit that has one light for two with the doubt which of them is where."""
    beside = history.beside
    if beside is None or fit.beside is not None or not history.is_certain(TWO_LIGHTS):
        return fit
    return replace(
        fit, covariance=fit.covariance + np.outer(beside.shift, beside.shift) / 4.0
    )
