"""What is said of joints that say nothing."""

from __future__ import annotations

from math import nan

from blob_tracker.ros.diagnostics.joint_news import JointNews, SILENCE_NS
import pytest

LATE = 2 * SILENCE_NS
ASKED = {'joints.pan': 'pan', 'joints.tilt': 'tilt'}


def news(asked: dict[str, str] = ASKED) -> JointNews:
    """Return that of these joints, asked for at 1 ns."""
    return JointNews(asked, 1)


def test_nothing_is_said_of_joints_that_come() -> None:
    """One a message, beside wheels."""
    heard = news()
    for index in range(10):
        now_ns = index * SILENCE_NS // 2
        for names, angles in ((['left', 'right'], {}), (['pan'], {'pan': 0.1}), (
            ['tilt'], {'tilt': 0.2}
        )):
            heard.heard(names)
            heard.took(angles, now_ns)
        assert heard.silent(now_ns) == ''


@pytest.mark.parametrize('names, angles, sentence', [
    ([], {}, 'no angle of pan and tilt arrives on joint_states, without which nothing can be '
             'predicted; start the driver of the pan/tilt, or remap joint_states'),
    (['left', 'right'], {}, 'it has left, right: set joints.pan and joints.tilt to those'),
    (['pan', 'tilt'], {'pan': nan, 'tilt': nan}, 'pan and tilt is NaN there: home the pan/tilt'),
    (['pan', 'head'], {'pan': 0.1}, 'it has head: set joints.tilt to those'),
    (['pan'], {'pan': 0.1}, 'pan came before: is its driver still running?; it has no others: '
                            'leave joints.tilt empty if there is none'),
])
def test_the_cause_of_silence(
    names: list[str], angles: dict[str, float], sentence: str
) -> None:
    """Never that a parameter is to be set to what it is."""
    heard = news()
    heard.heard(names)
    heard.took(angles, 1)
    assert sentence in heard.silent(LATE)
    assert 'set joints.pan to pan' not in heard.silent(LATE)


def test_angles_beyond_a_turn_may_be_degrees() -> None:
    """Of a joint that is asked for; within a turn nobody can tell."""
    heard = news()
    heard.took({'pan': 3.1, 'tilt': nan}, 1)
    assert heard.beyond_a_turn == ''
    heard.took({'pan': -50.0}, 2)
    assert heard.beyond_a_turn == 'pan is -50.0 rad: is that in degrees?'


def test_only_joints_that_several_nodes_publish_are_mixed() -> None:
    """Of two publishers that have each a joint none is."""
    heard = news()
    for index in range(10):
        heard.numbered(['pan'], 100 + index, 2 * index * 1000)
        heard.numbered(['tilt'], index, (2 * index + 1) * 1000)
    assert heard.mixed == []
    for index in range(10):
        heard.numbered(['pan'], (7 if index % 2 else 200) + index, (30 + index) * 1000)
    assert heard.mixed == ['pan']
