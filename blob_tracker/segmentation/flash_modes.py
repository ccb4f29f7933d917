"""The ways in which a light may flash, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature

from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.segmentation.coded import Coded
from blob_tracker.segmentation.flash import Flash
from blob_tracker.segmentation.periodic import Periodic
from blob_tracker.segmentation.steady import Steady

FLASH_MODES: dict[str, Callable[..., Flash]] = {
    'alternate': Alternate,
    'steady': Steady,
    'periodic': Periodic,
    'coded': Coded,
}


def flash_by_name(mode: str, **options: object) -> Flash:
    """
    Return a flash mode with those of the options that it has.

    Parameters
    ----------
    mode : str
        A key of `FLASH_MODES`.
    **options
        Those of all modes: max_pair_interval, registration, gate_px, frequency, duty, frames,
        codes, frames_per_bit, bit_errors.

    Returns
    -------
    Flash
        The mode, which has seen no frame.

    Raises
    ------
    ValueError
        Where there is no such mode, or one of its options cannot be.

    """
    if mode not in FLASH_MODES:
        raise ValueError(f"no flash mode '{mode}'; there is {', '.join(FLASH_MODES)}")
    create = FLASH_MODES[mode]
    known = signature(create).parameters
    return create(**{name: value for name, value in options.items() if name in known})


def codes_from_text(text: str) -> Mapping[str, str]:
    """Return the codes by name of 'port:1101000,starboard:1110100'."""
    codes: dict[str, str] = {}
    for part in filter(None, text.replace(' ', '').split(',')):
        name, _, bits = part.partition(':')
        if name in codes:
            raise ValueError(f"two codes are called '{name}'")
        codes[name] = bits
    return codes
