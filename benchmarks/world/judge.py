"""The figures of a situation, and whether they are right."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isnan, nan
import re

from benchmarks.world.play import Played
from benchmarks.world.situation import Floats, Situation
import numpy as np

FOUND = 0.95  # of the lit frames
WRONG = 0.001  # of the bearings
NEES = (1.4, 2.8)  # 2 is true
OVER_BOUND = 1.3  # rms
SIGMAS = 5.0  # of its own, from which on a bearing is wrong
NEAR = 0.1  # px, within which none is
SHOWN = 400  # distances that are kept for the plots
PASSED = ('found', 'silent')


@dataclass(frozen=True)
class Row:
    """
    One situation.

    Parameters
    ----------
    number : int
        Of the table's row.
    kind, strength : str
        What, and how much.
    lit, bearings : int
        Lit frames, and answers.
    found : float
        Share of the lit frames with a bearing; NaN where there is nothing to be found.
    wrong : float
        Share of the bearings that are more than 5 of their own sigmas and 0.1 px off; where there
        is nothing to be found, bearings over frames.
    rms, ratio : float
        Error along one axis, px, and over the Cramer-Rao bound; NaN without one.
    nees : float
        Mean of e^T C^-1 e: 2 where the covariance is true.
    chi2 : float
        Mean of the locations'.
    said : str
        What was said most often where there should have been a bearing, and warned of.
    verdict : str
        'found', 'silent', or what is not right.
    distances : list of float
        Error over sigma, sqrt(e^T C^-1 e / 2), of up to 400 bearings.

    """

    number: int
    kind: str
    strength: str
    lit: int
    bearings: int
    found: float
    wrong: float
    rms: float
    ratio: float
    nees: float
    chi2: float
    said: str
    verdict: str
    distances: list[float] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether it is found as it should be, or rightly silent."""
        return self.verdict in PASSED


def judge(situation: Situation, played: Played) -> Row:
    """Return the row of a situation that was played."""
    errors = np.reshape(played.errors, (-1, 2))
    covariances = np.reshape(played.covariances, (-1, 2, 2))
    if situation.centred and len(errors):
        # The median: a stray bearing must not move the middle.
        errors = errors - np.nanmedian(errors, axis=0)
    squares = squared_distances(errors, covariances)
    astray = np.isnan(squares) | (
        (squares > SIGMAS**2) & (np.hypot(errors[:, 0], errors[:, 1]) > NEAR)
    )
    here = ~np.isnan(squares)
    rms = _root_mean(errors[here] ** 2)
    bound = nan
    if played.bounds:
        bound = _root_mean(np.trace(played.bounds, axis1=1, axis2=2) / 2.0)
    among = len(errors) if played.lit else played.frames
    found = played.found / played.lit if played.lit else nan
    wrong = float(astray.sum()) / among if among else 0.0
    nees = float(squares[here].mean()) if here.any() else nan
    said = ''
    if played.said:
        said = played.words[played.said.most_common(1)[0][0]]
    step = max(1, -(-int(here.sum()) // SHOWN))
    return Row(
        situation.number, situation.kind, situation.strength, played.lit, len(errors), found,
        wrong, rms, rms / bound, nees, float(np.mean(played.chi2)) if played.chi2 else nan, said,
        verdict(found, wrong, nees, rms / bound, said, situation.reason),
        [float(each) for each in np.sqrt(squares[here][::step] / 2.0)],
    )


def verdict(
    found: float, wrong: float, nees: float, ratio: float, said: str, reason: str
) -> str:
    """
    Say 'found', 'silent' or what is not right.

    Parameters
    ----------
    found, wrong, nees, ratio : float
        See `Row`; a NaN `ratio` is not judged.
    said : str
        The most frequent sentence.
    reason : str
        Regular expression of one that names the cause.

    """
    if wrong > WRONG:
        return 'wrong'
    true = NEES[0] <= nees <= NEES[1]
    if found >= FOUND and true and not ratio > OVER_BOUND:
        return 'found'
    if said and re.search(reason, said, re.IGNORECASE):
        return 'silent'
    if isnan(found):
        return 'no reason'
    if found < FOUND:
        return 'not found'
    return 'rms' if true else 'NEES'


def squared_distances(errors: Floats, covariances: Floats) -> Floats:
    """Return e^T C^-1 e of each error, from (N, 2) and (N, 2, 2) arrays."""
    whitened = np.linalg.solve(covariances, errors[:, :, None])[:, :, 0]
    return np.asarray((errors * whitened).sum(axis=1))


def _root_mean(squares: Floats) -> float:
    """Return the root of the mean, NaN of nothing."""
    return float(np.sqrt(squares.mean())) if squares.size else nan
