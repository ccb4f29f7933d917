"""All frames that were spoken of, and how any lies in any other at an instant."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from blob_tracker.transforms.errors import NoTransform, TransformError
from blob_tracker.transforms.link import Link
from blob_tracker.transforms.transform import checked, inverse, product, Transform

MOST_FRAMES = 2000  # a humanoid has a hundred
MOST_PARENTS = 4  # of one frame, of which more than one is a fault
MOST_WORDS = 300  # characters in which the frames that are known are told


class Found(NamedTuple):
    """
    A transform, and the frames on the way that move in their parents.

    Parameters
    ----------
    transform : Transform
        How the one lies in the other.
    moving : tuple of str
        Empty where it holds for good.

    """

    transform: Transform
    moving: tuple[str, ...]


class TransformTree:
    """
    Keep how frames lie in each other.

    Each frame has one parent. Between two stamps the translation is linear and the rotation on a
    great circle; nothing is extrapolated. Where two nodes name different parents of a frame,
    nobody knows which is right, and nothing is told through it until one of them has said nothing
    for as long as transforms are kept.

    Parameters
    ----------
    hold : float
        Longest time between two transforms that are interpolated, s.
    memory : float
        Time for which they are kept, s; a late one within it is put in its place.

    """

    def __init__(self, hold: float = 0.2, memory: float = 2.0) -> None:
        self._hold_ns, self._memory_ns = round(1e9 * hold), round(1e9 * memory)
        self._links: dict[str, dict[str, Link]] = {}  # by the frame, by its parent

    @property
    def frames(self) -> list[str]:
        """Names of all frames."""
        parents = {parent for links in self._links.values() for parent in links}
        return sorted(self._links.keys() | parents)

    def put_static(self, frame: str, parent: str, transform: Transform) -> None:
        """
        Take a transform that holds for good.

        Parameters
        ----------
        frame, parent : str
            The frame, and that in which it lies.
        transform : Transform
            How.

        Raises
        ------
        TransformError
            If it cannot be, with a reason.

        """
        transform = checked(transform)
        self._link(frame, parent).fixed = transform

    def put(self, frame: str, parent: str, transform: Transform, stamp_ns: int) -> float:
        """
        Take the transform of an instant.

        Parameters
        ----------
        frame, parent : str
            The frame, and that in which it lies.
        transform : Transform
            How.
        stamp_ns : int
            ns of ROS time.

        Returns
        -------
        float
            By how much its stamps jumped back, s: what was known of it is forgotten then. 0 where
            they did not.

        Raises
        ------
        TransformError
            If it cannot be, with a reason.

        """
        transform = checked(transform)
        if stamp_ns <= 0:
            raise TransformError('it has no stamp; on /tf each must have that of its instant')
        jumped = self._link(frame, parent).put(transform, stamp_ns)
        if len(self._links[frame]) > 1:
            self._part_with_others(frame, parent, stamp_ns)
        return 1e-9 * jumped

    def forget(self, after_ns: int) -> None:
        """Forget what has a later stamp, ns; what holds for good stays."""
        for links in self._links.values():
            for link in links.values():
                link.forget(after_ns)

    def lookup(self, frame: str, reference: str, stamp_ns: int) -> Found:
        """
        Return how a frame lies in another at an instant.

        Parameters
        ----------
        frame, reference : str
            Their names.
        stamp_ns : int
            ns of ROS time.

        Returns
        -------
        Found
            Its transform takes components in `frame` to those in `reference`.

        Raises
        ------
        NoTransform
            If it is not known, with a reason.

        """
        up, down = self._ways(frame, reference)
        moving = tuple(link.frame for link in (*up, *down) if link.fixed is None)
        own, others = _along(up, stamp_ns), _along(down, stamp_ns)
        return Found(product(inverse(others), own), moving)

    def fixed(self, frame: str, reference: str) -> Transform:
        """
        Return how a frame lies in another for good.

        Parameters
        ----------
        frame, reference : str
            As in `lookup`.

        Raises
        ------
        NoTransform
            If it is not known, or moves, with a reason.

        """
        up, down = self._ways(frame, reference)
        moving = [link for link in (*up, *down) if link.fixed is None]
        if moving:
            words = ', '.join(f"'{link.frame}' in '{link.parent}'" for link in moving)
            raise NoTransform(
                f"'{frame}' is to be fixed in '{reference}', and moves: {words} comes on /tf; it "
                'must come on /tf_static'
            )
        return product(inverse(_along(down, 0)), _along(up, 0))

    def _ways(self, frame: str, reference: str) -> tuple[list[Link], list[Link]]:
        """Return the links from each of two frames to the first that both lie in."""
        for name in (frame, reference):
            fault = wrong_name(name)
            if fault:
                raise NoTransform(fault)
        up, down = list(self._chain(frame)), list(self._chain(reference))
        roots = [chain[-1].parent if chain else name
                 for chain, name in ((up, frame), (down, reference))]
        if roots[0] != roots[1]:
            raise NoTransform(self._unconnected(frame, reference, roots), may_come=True)
        while up and down and up[-1] is down[-1]:
            up.pop()
            down.pop()
        return up, down

    def _link(self, frame: str, parent: str) -> Link:
        """Return how a frame lies in a parent, made anew where nothing was said of it."""
        links = self._links.get(frame, {})
        if parent in links:
            return links[parent]
        for name in (frame, parent):
            fault = wrong_name(name)
            if fault:
                raise TransformError(fault)
        if frame == parent or frame in self._above(parent):
            raise TransformError(
                f"'{frame}' in '{parent}' closes a circle: '{parent}' lies in '{frame}' already"
            )
        if len(self._links) >= MOST_FRAMES or len(links) >= MOST_PARENTS:
            raise TransformError(
                f"there are {len(self._links)} frames, and '{frame}' has {len(links)} parents: no "
                'more are kept'
            )
        link = Link(frame, parent, self._hold_ns, self._memory_ns)
        self._links.setdefault(frame, {})[parent] = link
        return link

    def _part_with_others(self, frame: str, parent: str, stamp_ns: int) -> None:
        """Forget the parents of a frame of which nothing was said for long; not this one."""
        for other, link in list(self._links[frame].items()):
            newest_ns = link.newest_ns
            gone = newest_ns is not None and newest_ns < stamp_ns - self._memory_ns
            if other != parent and gone and link.fixed is None:
                del self._links[frame][other]

    def _above(self, frame: str) -> set[str]:
        """Return all frames in which one lies, by any of its parents."""
        found: set[str] = set()
        ahead = set(self._links.get(frame, ()))
        while ahead:
            found |= ahead
            ahead = {above for name in ahead for above in self._links.get(name, ())} - found
        return found

    def _chain(self, frame: str) -> Iterator[Link]:
        """Yield the links from a frame to the root of its tree."""
        while frame in self._links:
            link, *others = self._links[frame].values()
            if others:
                names = ' and '.join(f"'{name}'" for name in sorted(self._links[frame]))
                raise NoTransform(
                    f"'{frame}' has two parents, {names}: two nodes publish where it is, and only "
                    'one can be right'
                )
            yield link
            frame = link.parent

    def _unconnected(self, frame: str, reference: str, roots: list[str]) -> str:
        """Return what is known, and what would connect two frames."""
        known = self.frames
        if not known:
            return (
                f"no transform at all has come, and '{frame}' is to be placed in '{reference}': "
                'is robot_state_publisher or static_transform_publisher running?'
            )
        strange = [name for name in dict.fromkeys((frame, reference)) if name not in known]
        below, above = roots
        words = ' and '.join(f"'{name}'" for name in strange)
        return (
            (f'nothing was said of {words}' if strange
             else f"'{frame}' and '{reference}' are in two trees")
            + f"; publish where '{below}' lies in '{above}', or in a frame that is connected to "
            f'it; known are {self._told()}'
        )

    def _told(self) -> str:
        """Return the frames in words, each tree from its root."""
        children: dict[str, list[str]] = {}
        for frame, links in self._links.items():
            for parent in links:
                children.setdefault(parent, []).append(frame)
        trees = [
            f'{parent} > {", ".join(sorted(frames))}'
            for parent, frames in sorted(children.items())
        ]
        words = '; '.join(trees)
        return words if len(words) <= MOST_WORDS else f'{words[:MOST_WORDS]}...'


def wrong_name(frame: str) -> str:
    """Return why this is no name of a frame; empty if it is one."""
    if not frame:
        return 'the name of a frame is empty: its publisher must set frame_id'
    if frame.startswith('/'):
        return (
            f"'{frame:.80}' begins with /, which no frame of tf2 does: let its publisher leave "
            'that out'
        )
    return ''


def _along(links: list[Link], stamp_ns: int) -> Transform:
    """Return how the frame at the beginning of a chain lies in that at its end."""
    found = Transform()
    for link in links:
        found = product(link.at(stamp_ns), found)
    return found
