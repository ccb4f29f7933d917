"""camera_info_url: paths, file:// and package://."""

from pathlib import Path

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters.url import DEFAULT_CALIBRATION_URL, to_path
import pytest


def test_paths_and_urls() -> None:
    """A path stays, file:// loses its scheme, package:// is looked up."""
    assert to_path('/a/b.yaml') == to_path('file:///a/b.yaml') == Path('/a/b.yaml')
    assert to_path('package://blob_tracker/config/camera_info.yaml').is_file()


@pytest.mark.parametrize(
    'url, sentence',
    [
        ('package://no_such_package/a.yaml', "no package 'no_such_package' is installed"),
        ('http://example.com/a.yaml', 'not http://'),
        ('file://a/b.yaml', 'comes an absolute path: file:///'),
        ('file:///${HOME}/a', r'\$\{HOME\} is not known; there is \$\{NAME\}, \$\{ROS_HOME\}'),
        ('/a/${}.yaml', r'\$\{\} is not known'),
    ],
)
def test_wrong_urls(url: str, sentence: str) -> None:
    """Another scheme and a package that is not there."""
    with pytest.raises(ParameterError, match=sentence):
        to_path(url)


def test_without_any_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the wheels leave it where nothing was built: the same sentence, no fault of ament's."""
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    with pytest.raises(ParameterError, match="no package 'mast' is installed"):
        to_path('package://mast/a.yaml')


def test_names_in_urls(monkeypatch: pytest.MonkeyPatch) -> None:
    """${NAME} and ${ROS_HOME}, in each scheme, more than once, and a $ that is only a $."""
    monkeypatch.setenv('ROS_HOME', '/var/ros')
    assert to_path('file://${ROS_HOME}/${NAME}/${NAME}.yaml', 'left') == Path(
        '/var/ros/left/left.yaml'
    )
    assert to_path('${ROS_HOME}/a.yaml') == Path('/var/ros/a.yaml')
    assert to_path('/a/$NAME/{NAME}.yaml') == Path('/a/$NAME/{NAME}.yaml')
    assert to_path(DEFAULT_CALIBRATION_URL, 'left') == Path('/var/ros/camera_info/left.yaml')


def test_ros_home_of_a_user(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the environment does not name it, or has it empty, it is ~/.ros."""
    monkeypatch.setenv('HOME', '/home/ann')
    for forget in (lambda: monkeypatch.delenv('ROS_HOME', raising=False),
                   lambda: monkeypatch.setenv('ROS_HOME', '')):
        forget()
        assert to_path('file://${ROS_HOME}/a.yaml') == Path('/home/ann/.ros/a.yaml')


def test_names_in_package_urls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The package's own name may be one of them."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'mast').touch()
    (tmp_path / 'share' / 'mast').mkdir()
    assert to_path('package://${NAME}/${NAME}.yaml', 'mast') == (
        tmp_path / 'share' / 'mast' / 'mast.yaml'
    )
