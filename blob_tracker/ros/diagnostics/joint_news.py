"""What arrives of the joints that are asked for, and why one of them says nothing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isnan, tau

from blob_tracker.ros.diagnostics.interleaving import Interleaving

SILENCE_NS = 1_000_000_000  # ns of ROS time without an angle that are worth a word
MOST_NAMES = 100  # of other joints that are remembered: a humanoid has fewer


class JointNews:
    """
    Keep when each joint was last heard of.

    Parameters
    ----------
    asked : mapping of str to str
        Names of the joints by the parameters that have them, without empty ones.
    now_ns : int
        When they were asked for, ns of ROS time.

    """

    def __init__(self, asked: Mapping[str, str], now_ns: int) -> None:
        self._asked = dict(asked)
        self._heard: dict[str, None] = {}  # names, in their order
        self._unknown: set[str] = set()  # joints of which the last angle is NaN
        self._angles: dict[str, float] = {}  # the last, rad
        self._senders = {name: Interleaving() for name in asked.values()}
        self.restart(now_ns)

    def restart(self, now_ns: int) -> None:
        """Wait anew: what follows is of another time."""
        self._came_ns = dict.fromkeys(self._asked.values(), now_ns)

    def heard(self, names: Iterable[str]) -> None:
        """Take note of the joints of a message."""
        for name in names:
            if len(self._heard) < MOST_NAMES:
                self._heard[name] = None

    def took(self, angles: Mapping[str, float], now_ns: int) -> None:
        """Take note of the angles of joints that are asked for, rad; NaN is none."""
        for name, angle in angles.items():
            if isnan(angle):
                self._unknown.add(name)
            else:
                self._unknown.discard(name)
                self._came_ns[name] = now_ns
                self._angles[name] = angle

    def numbered(self, names: Iterable[str], number: int, sent_ns: int) -> None:
        """Take note of the publisher's number and the time of a message of these joints."""
        for name in names:
            self._senders[name].took(number, sent_ns)

    @property
    def mixed(self) -> list[str]:
        """Joints that are asked for and published by several nodes."""
        return [name for name, each in self._senders.items() if each.mixed]

    @property
    def beyond_a_turn(self) -> str:
        """Say which joints stand further off than a turn, as one does in degrees; '' if none."""
        far = [
            f'{name} is {angle:.1f} rad' for name, angle in self._angles.items()
            if abs(angle) > tau
        ]
        return f'{" and ".join(far)}: is that in degrees?' if far else ''

    def silent(self, now_ns: int) -> str:
        """Return which joints say nothing at an instant, ns, and what to do; empty if none."""
        silent = [
            name for name, came_ns in self._came_ns.items()
            if came_ns > 0 and now_ns - came_ns > SILENCE_NS
        ]
        if now_ns > 0:  # simulated time began at 0 and leapt: from the next look on it counts
            for name, came_ns in self._came_ns.items():
                self._came_ns[name] = came_ns or 1
        if not silent:
            return ''
        hints = []
        unknown = [name for name in silent if name in self._unknown]
        if unknown:
            hints.append(f'{" and ".join(unknown)} is NaN there: home the pan/tilt')
        ended = [name for name in silent if name in self._heard and name not in unknown]
        if ended:
            hints.append(f'{" and ".join(ended)} came before: is its driver still running?')
        others = [name for name in self._heard if name not in self._asked.values()]
        strange = [
            parameter for parameter, name in self._asked.items()
            if name in silent and name not in self._heard
        ]
        if strange and others:
            hints.append(f'it has {", ".join(others):.200}: set {" and ".join(strange)} to those')
        elif strange and self._heard:
            hints.append(f'it has no others: leave {" and ".join(strange)} empty if there is none')
        elif strange:
            hints.append('start the driver of the pan/tilt, or remap joint_states')
        return (
            f'no angle of {" and ".join(silent)} arrives on joint_states, without which nothing '
            f'can be predicted; {"; ".join(hints)}'
        )
