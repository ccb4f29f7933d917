"""How a light flashes, in the words of a parameter: nothing that takes long to load."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

# What `blob_tracker.segmentation.FLASH_MODES` has.
FLASH_MODE_NAMES = ('alternate', 'steady', 'periodic', 'coded', 'lock_in', 'auto')
DUTIES = (0.05, 0.95)  # that flash.duty may be
MOST_UNNAMED = 24  # lights; what `blob_tracker.constellation.assignment` distinguishes


def numbered_lights(count: int) -> tuple[str, ...]:
    """Return the names of so many lights without names; of a single one it is empty."""
    return tuple(f'light_{number + 1}' for number in range(count)) if count > 1 else ('',)


def codes_from_text(text: str) -> Mapping[str, str]:
    """
    Return the codes by name of 'port:1101000,starboard:1110100'.

    Raises
    ------
    ValueError
        If two have one name, or one has none.

    """
    codes: dict[str, str] = {}
    for name, bits in _named(text):
        if name in codes:
            raise ValueError(f"two codes are called '{name}'")
        codes[name] = bits
    return codes


def frequencies_from_text(text: str) -> Mapping[str, float]:
    """
    Return the frequencies, Hz, by name of 'port:6.0,starboard:10.0'.

    Raises
    ------
    ValueError
        If two have one name, or one is no number.

    """
    frequencies: dict[str, float] = {}
    for name, value in _named(text):
        if name in frequencies:
            raise ValueError(f"two frequencies are called '{name}'")
        try:
            frequencies[name] = float(value)
        except ValueError:
            raise ValueError(
                f"the frequency of '{name}' is '{value}'; it must be a number of Hz"
            ) from None
    return frequencies


def _named(text: str) -> Iterator[tuple[str, str]]:
    """Yield name and value of each part of 'port:1101000,starboard:1110100'."""
    for part in filter(None, text.replace(' ', '').split(',')):
        name, colon, value = part.partition(':')
        if not (name and colon):
            right = part.strip(':').replace('=', ':')
            right = right if ':' in right else f'port:{right}'
            raise ValueError(f"'{part}' is not a light; write its name before it: '{right}'")
        yield name, value
