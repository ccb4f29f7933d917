"""camera_info_url: paths, file:// and package://."""

from pathlib import Path

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.url import to_path
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
    ],
)
def test_wrong_urls(url: str, sentence: str) -> None:
    """Another scheme and a package that is not there."""
    with pytest.raises(ParameterError, match=sentence):
        to_path(url)
