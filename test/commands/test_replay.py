"""Bags through the real nodes: every bearing against the recorded truth, at any speed."""

from __future__ import annotations

from pathlib import Path
import shutil

from blob_tracker.commands.replay import _offered_qos, missing_nodes
from blob_tracker.resources import config_path
from blob_tracker.ros.bags import Topic
from blob_tracker.ros.messages.stamp import to_ns
from geometry_msgs.msg import PointStamped, Vector3Stamped
import pytest
from rclpy.qos import DurabilityPolicy, qos_profile_sensor_data, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image
from support.bags import of_best_effort, of_compressed, rewritten
from support.processes import probe, start, start_replay

BAGS = Path(__file__).parents[1] / 'bags'
FRAMES, LIT = 59, 30  # in the bag, and lit ones of them
# The first lit frame has no unlit one before it, and the one after the dropped frame has a lit
# one 67 ms before it, still within max_pair_interval: the light moved, and the pair is refused.
LOCATED = LIT - 2


def replayed(bag: str, rate: float, domain: int) -> tuple[list, list, list, list]:
    """Replay a bag through segmenter and locator; return bearings, centroids and both truths."""
    parameters = ('--params-file', str(config_path('replay.yaml')))
    with probe(domain) as node:
        bearings = node.record(Vector3Stamped, 'target/bearing')
        centroids = node.record(PointStamped, 'target/centroid')
        true_bearings = node.record(Vector3Stamped, 'simulator/truth/bearing')
        true_centroids = node.record(PointStamped, 'simulator/truth/centroid')
        with start('segmenter', domain, *parameters), start('locator', domain, *parameters):
            node.spin_until(lambda: node.count_publishers('target/bearing'))
            node.spin_until(lambda: node.count_subscribers('target/window/image_raw'))
            with start_replay(
                BAGS / bag, domain, '--rate', str(rate), '--wait', '20',
                '--nodes', 'probe', 'segmenter', 'locator',
            ) as replay:
                node.spin_until(lambda: not replay.running)
                assert replay.wait() == 0, replay.output
            node.spin_until(lambda: len(bearings) == len(centroids) >= LOCATED)
            node.settle(0.3)  # any that should not be there
    return bearings, centroids, true_bearings, true_centroids


@pytest.fixture(scope='module')
def runs(module_domain: int) -> dict[tuple[str, float], tuple[list, list, list, list]]:
    """Return the outcome of each replay, made once for all tests."""
    cases = (('flash_mcap', 1.0), ('flash_mcap', 10.0), ('flash_sqlite3', 10.0))
    return {case: replayed(*case, domain=module_domain) for case in cases}


def test_every_bearing_is_the_recorded_truth(runs) -> None:
    """A bearing comes for every pair, within five standard deviations of the truth."""
    for bearings, centroids, true_bearings, true_centroids in runs.values():
        truth = {to_ns(m.header.stamp): m.vector for m in true_bearings}
        places = {to_ns(m.header.stamp): m.point for m in true_centroids}
        assert len(truth) == LIT
        assert len(bearings) == LOCATED
        for message in bearings:
            true = truth[to_ns(message.header.stamp)]
            # 0.06 px, which is five sigma of this scene, through a lens of 150 px.
            assert message.vector.x == pytest.approx(true.x, abs=0.06 / 150 * 1e3)
            assert message.vector.y == pytest.approx(true.y, abs=0.06 / 150 * 1e3)
            assert message.header.frame_id == 'camera_optical_frame'
        for message in centroids:
            true = places[to_ns(message.header.stamp)]
            assert message.point.x == pytest.approx(true.x, abs=0.06)
            assert message.point.y == pytest.approx(true.y, abs=0.06)


def test_rate_and_storage_change_no_bit(runs) -> None:
    """Rate 1 and 10, mcap and sqlite3: the same messages to the last bit."""
    first, *others = [
        [[(to_ns(m.header.stamp), m.vector.x, m.vector.y) for m in run[0]],
         [(to_ns(m.header.stamp), m.point.x, m.point.y) for m in run[1]]]
        for run in runs.values()
    ]
    for other in others:
        assert other == first


def test_clock_runs_with_the_bag(domain: int) -> None:
    """--clock publishes the recorded time, forward only, from the first stamp to the last."""
    with probe(domain) as node:
        clocks = node.record(Clock, '/clock', 1000)
        node.record(Image, '/camera/image_raw')
        with start_replay(BAGS / 'flash_mcap', domain, '--clock', '--rate', '5') as replay:
            node.spin_until(lambda: not replay.running)
            assert replay.wait() == 0, replay.output
            node.settle(0.2)
    stamps = [to_ns(message.clock) for message in clocks]
    assert stamps == sorted(stamps)
    assert stamps[0] == 1_700_000_000_000_000_000
    assert stamps[-1] - stamps[0] == pytest.approx(59 / 30 * 1e9, abs=2e7)


def test_chosen_topics_are_played_to_a_node_that_is_awaited(domain: int) -> None:
    """--topics leaves out the others, and says what is not there; --nodes waits."""
    with probe(domain) as node:
        truths = node.record(Vector3Stamped, 'simulator/truth/bearing')
        arguments = (
            '--topics', '/simulator/truth/bearing', '/camera/image_row', '--rate', '20',
            '--wait', '3',
        )
        with start_replay(
            BAGS / 'flash_mcap', domain, *arguments, '--nodes', '/probe'
        ) as replay:
            node.spin_until(lambda: not replay.running or node.count_publishers(
                'simulator/truth/bearing'))
            assert not node.count_publishers('camera/image_raw')
            node.spin_until(lambda: not replay.running)
            assert replay.wait() == 0, replay.output
            node.settle(0.2)
    assert len(truths) == LIT
    assert 'flash_mcap has no /camera/image_row; its topics are /camera/camera_info, ' in (
        replay.output)


def test_nodes_are_awaited_by_name_or_by_full_name() -> None:
    """A name alone is that of any namespace."""
    there = [('probe', '/'), ('segmenter', '/left')]
    assert not missing_nodes(['probe', '/probe', 'segmenter', '/left/segmenter'], there)
    assert not missing_nodes(['left/segmenter'], there)
    strange = ['/segmenter', '/right/segmenter', 'left', 'rosout']
    assert missing_nodes(strange, there) == set(strange)


@pytest.mark.parametrize('name, durability', [
    ('/tf_static', DurabilityPolicy.TRANSIENT_LOCAL), ('/tf', DurabilityPolicy.VOLATILE),
])
def test_static_transforms_are_kept_for_who_comes_late(
    name: str, durability: DurabilityPolicy
) -> None:
    """Also where the bag does not remember how they were offered."""
    topic = Topic(name, 'tf2_msgs/msg/TFMessage')
    assert _offered_qos(topic, 5).durability == durability


def test_nodes_that_do_not_come_are_named(domain: int) -> None:
    """Nothing is played then: what takes it would miss it."""
    arguments = ('--wait', '0.2', '--nodes', 'nobody', 'no_one')
    with start_replay(BAGS / 'flash_mcap', domain, *arguments) as replay:
        assert replay.wait() == 1, replay.output
    assert 'nothing is played: no_one, nobody of --nodes did not come within 0.2 s' in (
        replay.output)


@pytest.mark.parametrize(
    'arguments, sentence, code',
    [
        (['/no/such/bag'], 'there is no bag', 1),
        ([str(Path(__file__).parent)], 'is not a bag that can be read', 1),
        ([str(BAGS / 'flash_mcap'), '--rate', '0'], 'it must be above 0', 2),
        ([str(BAGS / 'flash_mcap'), '--rate', 'fast'], "'fast' is not a number", 2),
        ([str(BAGS / 'flash_mcap'), '--remap', '/a'], '/a is not of the form FROM:=TO', 2),
        ([str(BAGS / 'flash_mcap'), '--remap', '/a:=/1'], '/a:=/1: Invalid topic name', 2),
        (
            [str(BAGS / 'flash_mcap'), '--remap', '/a:=/b'],
            'has no /a; its topics are /camera/camera_info, ',
            1,
        ),
        (
            [str(BAGS / 'flash_mcap'), '--remap', '/camera/camera_info:=/camera/image_raw'],
            '--remap gives two topics one name',
            1,
        ),
        (
            [str(BAGS / 'flash_mcap'), '--topics', '/nothing'],
            'holds no messages of /nothing; its topics are /camera/camera_info, ',
            1,
        ),
    ],
)
def test_wrong_use_says_what_is_wrong(
    arguments: list[str], sentence: str, code: int, domain: int
) -> None:
    """A missing bag, a folder that is none, and an impossible rate each give one sentence."""
    with start_replay(Path(arguments[0]), domain, *arguments[1:]) as replay:
        assert replay.wait() == code
    assert sentence in replay.output
    assert 'Traceback' not in replay.output


def test_a_killed_bag_is_played_to_its_end(domain: int, tmp_path: Path) -> None:
    """With a word on what is there; nothing was promised, and nothing is missed."""
    bag = tmp_path / 'killed'
    bag.mkdir()
    content = (BAGS / 'flash_mcap' / 'flash_mcap.mcap').read_bytes()
    (bag / 'killed_0.mcap').write_bytes(content[:-60_000])
    with probe(domain) as node:
        node.record(Image, '/camera/image_raw')
        with start_replay(bag, domain, '--rate', '50', '--nodes', 'probe') as replay:
            assert replay.wait() == 0, replay.output
    assert 'it has no metadata.yaml; it ends in the middle of a record' in replay.output
    assert '164 messages of 1.800 s are there' in replay.output


def test_a_bag_that_has_not_what_it_promises_ends_with_1(domain: int, tmp_path: Path) -> None:
    """After all that is there was played."""
    bag = tmp_path / 'edited'
    shutil.copytree(BAGS / 'flash_sqlite3', bag)
    metadata = bag / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('message_count: 59', 'message_count: 60'))
    with probe(domain) as node:
        node.record(Image, '/camera/image_raw')
        with start_replay(bag, domain, '--rate', '50', '--nodes', 'probe') as replay:
            assert replay.wait() == 1, replay.output
    assert '/camera/image_raw: 60 messages are promised and 59 came' in replay.output
    assert 'Traceback' not in replay.output


def played(bag: Path, domain: int, *arguments: str, **topics: object) -> tuple[int, str, list]:
    """Replay a bag to the usual subscriptions of a pipeline: exit code, words, and images."""
    with probe(domain) as node:
        images = node.record(Image, '/camera/image_raw', **topics)
        node.record(CameraInfo, '/camera/camera_info', **topics)
        with start_replay(bag, domain, '--rate', '20', *arguments) as replay:
            node.spin_until(lambda: not replay.running)
            code = replay.wait()
        node.settle(0.2)
    return code, replay.output, images


@pytest.mark.parametrize('qos, rate', [(100, '20'), (qos_profile_sensor_data, '2')])
def test_a_bag_of_a_best_effort_driver_serves_both_ends(
    qos: object, rate: str, domain: int, tmp_path: Path
) -> None:
    """It is offered reliably: nodes that must not lose a frame ask for that."""
    bag = of_best_effort(tmp_path / 'bag')
    code, words, images = played(bag, domain, '--rate', rate, qos=qos)
    assert code == 0, words
    assert images
    if qos == 100:
        assert len(images) == FRAMES


def test_a_replay_to_nobody_says_so(domain: int) -> None:
    """Nothing is played, and the exit code tells a script."""
    with start_replay(BAGS / 'flash_mcap', domain, '--wait', '0.5') as replay:
        assert replay.wait() == 1, replay.output
    assert 'nothing is played: nobody takes /camera/camera_info, /camera/image_raw, ' in (
        replay.output)
    assert 'within 0.5 s; start what takes it, or raise --wait' in replay.output


def test_topics_are_played_under_other_names(domain: int, tmp_path: Path) -> None:
    """As --remap says, and both names choose a topic."""
    bag = rewritten(tmp_path / 'bag', ('/camera/', '/left/'))
    code, words, images = played(
        bag, domain, '--topics', '/camera/image_raw', '/left/camera_info', '--remap',
        '/left/image_raw:=/camera/image_raw', 'left/camera_info:=camera/camera_info',
    )
    assert code == 0, words
    assert images
    assert 'no other images' not in words


@pytest.mark.parametrize('chosen', [(), ('--topics', '/camera/image_raw', '/camera/camera_info')])
def test_lone_images_find_the_pipeline(
    chosen: tuple[str, ...], domain: int, tmp_path: Path
) -> None:
    """With their camera_info, and a word on it: it was not asked for."""
    bag = rewritten(tmp_path / 'bag', ('/camera/', '/left/'))
    code, words, images = played(bag, domain, *chosen)
    assert code == 0, words
    assert images
    for name in ('image_raw', 'camera_info'):
        assert f'/left/{name} is played as /camera/{name}: no other images' in words


@pytest.mark.parametrize('name', ['/camera/image_raw', '/left/image_raw'])
def test_a_bag_of_compressed_images_is_located(name: str, domain: int, tmp_path: Path) -> None:
    """Every flash of it, by a segmenter that takes them, under whatever name they have."""
    bag = of_compressed(tmp_path / 'bag', name)
    patient = ('--params-file', str(config_path('replay.yaml')))
    with probe(domain) as node:
        bearings = node.record(Vector3Stamped, 'target/bearing')
        with (
            start('segmenter', domain, *patient, image_transport='compressed'),
            start('locator', domain, *patient),
        ):
            node.spin_until(lambda: node.count_publishers('target/bearing'))
            node.spin_until(lambda: node.count_subscribers('target/window/image_raw'))
            with start_replay(
                bag, domain, '--rate', '10', '--wait', '20', '--nodes', 'segmenter', 'locator',
                '--topics', '/camera/image_raw', '/camera/camera_info',
            ) as replay:
                node.spin_until(lambda: not replay.running)
                assert replay.wait() == 0, replay.output
            node.spin_until(lambda: len(bearings) >= LOCATED)
    assert len(bearings) == LOCATED
    moved = f'{name}/compressed is played as /camera/image_raw/compressed: no other images'
    assert (moved in replay.output) is (name != '/camera/image_raw')
    assert 'has no' not in replay.output


def test_compressed_images_that_nobody_takes_are_named(domain: int, tmp_path: Path) -> None:
    """With the parameter of the node that waits for raw ones."""
    bag = of_compressed(tmp_path / 'bag')
    code, words, images = played(
        bag, domain, '--wait', '1.5', '--topics', '/camera/image_raw', '/camera/camera_info')
    assert (code, images) == (1, []), words
    assert '/probe takes sensor_msgs/msg/Image of /camera/image_raw' in words
    assert 'set image_transport: compressed' in words


def test_images_that_no_pipeline_takes_are_named(domain: int, tmp_path: Path) -> None:
    """With the remap that would help, where nobody can tell which of two are meant."""
    bag = rewritten(tmp_path / 'bag', ('/camera/', '/left/'))
    with probe(domain) as node:
        for side in ('a', 'b'):
            node.record(Image, f'/{side}/camera/image_raw')
        with start_replay(bag, domain, '--wait', '1.5') as replay:
            node.spin_until(lambda: not replay.running)
            assert replay.wait() == 1, replay.output
    assert (
        '/probe takes images of /b/camera/image_raw: --remap '
        '/left/image_raw:=/b/camera/image_raw /left/camera_info:=/b/camera/camera_info'
    ) in replay.output


def test_a_subscriber_that_asks_for_more_is_named(domain: int) -> None:
    """With what it asks for and what it is offered."""
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    with probe(domain) as node:
        node.record(Image, '/camera/image_raw', latched)
        with start_replay(BAGS / 'flash_mcap', domain, '--wait', '1.5') as replay:
            node.spin_until(lambda: not replay.running)
            assert replay.wait() == 1, replay.output
    assert (
        '/probe asks for transient_local on /camera/image_raw, which is offered volatile'
    ) in replay.output
