"""Modes, codes and frequencies as parameters have them."""

from __future__ import annotations

from blob_tracker.constellation.assignment import MOST_BEARINGS
from blob_tracker.flash_text import (
    codes_from_text, FLASH_MODE_NAMES, frequencies_from_text, MOST_UNNAMED, numbered_lights,
)
from blob_tracker.segmentation import FLASH_MODES
import pytest


def test_every_mode_has_its_name() -> None:
    """No more and no fewer, in their order."""
    assert FLASH_MODE_NAMES == tuple(FLASH_MODES)


def test_lights_that_look_alike_are_numbered() -> None:
    """As many as a constellation takes; a single one has no name."""
    assert numbered_lights(1) == ('',)
    assert numbered_lights(3) == ('light_1', 'light_2', 'light_3')
    assert MOST_UNNAMED == MOST_BEARINGS


def test_codes_are_read_from_text() -> None:
    """Name and bits, parted by commas."""
    assert codes_from_text('port:110, star:010') == {'port': '110', 'star': '010'}
    assert codes_from_text('') == {}
    with pytest.raises(ValueError, match="two codes are called 'port'"):
        codes_from_text('port:110,port:010')


def test_frequencies_are_read_from_text() -> None:
    """Name and Hz."""
    assert frequencies_from_text('left:6.0, right:10') == {'left': 6.0, 'right': 10.0}
    for text, words in (
        ('left:6,left:7', "two frequencies are called 'left'"), ('left:six', 'a number of Hz'),
        ('6.0', "write its name before it: 'port:6.0'"),
        (':6.0', "write its name before it: 'port:6.0'"),
        ('left=6', "write its name before it: 'left:6'"),
    ):
        with pytest.raises(ValueError, match=words):
            frequencies_from_text(text)
