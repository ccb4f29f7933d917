"""Each mode is reached by its name with its own options."""

from blob_tracker.segmentation import flash_by_name, FLASH_MODES
import pytest

OPTIONS = {
    'max_pair_interval': 0.1,
    'registration': 'none',
    'gate_px': 24.0,
    'frequency': 15.0,
    'duty': 0.5,
    'frames': 16,
    'codes': {'only': '1101000'},
    'frequencies': {'other': 6.0},
    'frames_per_bit': 1,
    'bits_per_second': 0.0,
    'exposure': 0.0,
    'lights': 1,
}


@pytest.mark.parametrize('mode', FLASH_MODES)
def test_every_mode_is_made_from_the_same_options(mode: str) -> None:
    """It takes those that it has."""
    flash = flash_by_name(mode, **OPTIONS)
    assert type(flash) is FLASH_MODES[mode]
    assert flash.reason == 'no frame yet'


def test_an_option_of_no_mode_is_named() -> None:
    """With those that there are: one that is misspelt must not be left out."""
    with pytest.raises(TypeError, match='no flash mode has max_interval; there is bits_'):
        flash_by_name('alternate', max_interval=0.1)


def test_an_unknown_mode_is_named() -> None:
    """With those that there are."""
    with pytest.raises(ValueError, match="no flash mode 'disco'; there is alternate, "):
        flash_by_name('disco')
