"""Poses of a body beside the truth: errors at their own instants, and a picture of them."""

from __future__ import annotations

from io import StringIO
from pathlib import Path

from blob_tracker.commands.demo import _judge_body, _of_body
from blob_tracker.commands.watched_body import WatchedBody
from blob_tracker.ros.messages.body import quaternion, true_pose_message
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.simulation.flying_body import Flight
import cv2
from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
import pytest
from rich.console import Console
from scipy.spatial.transform import Rotation

BEGIN_NS = 10**18
SIGMAS = np.array([1e-3, 1e-3, 4e-3, 3e-3, 3e-3, 2e-3])  # m, rad


def flown(grown: float = 1.0, seconds: float = 6.0) -> WatchedBody:
    """Return a body with its truth at 30 Hz but for half a second, and poses between, in error."""
    random = np.random.default_rng(8)
    body, flight = WatchedBody('drone'), Flight()
    for frame in range(int(30 * seconds)):
        if not 60 <= frame < 75:
            body.take_truth(true_pose_message(
                *flight.pose(frame / 30.0), BEGIN_NS + round(1e9 * frame / 30.0), 'optical'))
    for time in np.arange(0.1, seconds, 0.05).tolist():
        rotation, position = flight.pose(time)
        error = grown * SIGMAS * random.normal(size=6)
        turn = Rotation.from_rotvec(error[3:]).as_matrix() @ rotation
        message = PoseWithCovarianceStamped()
        message.header.stamp = from_ns(BEGIN_NS + round(1e9 * time))
        place, turned = message.pose.pose.position, message.pose.pose.orientation
        place.x, place.y, place.z = (position + error[:3]).tolist()
        turned.x, turned.y, turned.z, turned.w = quaternion(turn)
        message.pose.covariance = np.diag(SIGMAS**2).ravel().tolist()
        body.take(message)
    return body


def test_errors_are_taken_at_the_instants_of_the_poses() -> None:
    """Between two frames, but not across a gap; of each as many sigmas as were drawn."""
    score = flown().score()
    assert score is not None
    assert 100 < len(score.times) < 118 - 9
    # 600 numbers know their rms to 3 %.
    assert score.scatter == pytest.approx(1.0, abs=0.12)
    place, turn = score.rms
    assert place == pytest.approx(np.sqrt((SIGMAS[:3] ** 2).sum()), rel=0.25)
    assert turn == pytest.approx(np.sqrt((SIGMAS[3:] ** 2).sum()), rel=0.25)
    assert WatchedBody('drone').score() is None


@pytest.mark.parametrize('grown, code, word', [
    (1.0, 0, 'as the covariances say'), (2.0, 1, 'MORE than'), (0.3, 1, 'LESS than'),
])
def test_the_verdict_is_by_the_covariance(
    grown: float, code: int, word: str, tmp_path: Path
) -> None:
    """Too wide is as wrong as too narrow; with a picture, and a table beside it."""
    printed, body = StringIO(), flown(grown)
    console = Console(file=printed, width=140)
    assert _judge_body(console, body, tmp_path / 'pose.png') == code
    assert word in printed.getvalue()
    assert cv2.imread(str(tmp_path / 'pose.png')).shape[1] >= 1000
    console.print(_of_body(body))
    assert 'rotation off (degrees rms)' in printed.getvalue()


def test_without_poses_there_is_nothing_to_judge(tmp_path: Path) -> None:
    """And no picture."""
    printed = StringIO()
    assert _judge_body(Console(file=printed), WatchedBody('drone'), tmp_path / 'pose.png') == 1
    assert 'only 0 poses came' in printed.getvalue()
    assert not list(tmp_path.iterdir())
