"""The ways in which a light may flash, by name."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature

from blob_tracker.segmentation.auto import Auto
from blob_tracker.segmentation.blink import Coded, Periodic
from blob_tracker.segmentation.flash import Flash
from blob_tracker.segmentation.in_step import InStep
from blob_tracker.segmentation.lock_in import LockIn
from blob_tracker.segmentation.steady import Steady

FLASH_MODES: dict[str, Callable[..., Flash]] = {
    'alternate': InStep,
    'steady': Steady,
    'periodic': Periodic,
    'coded': Coded,
    'lock_in': LockIn,
    'auto': Auto,
}


def flash_by_name(mode: str, **options: object) -> Flash:
    """
    Return a flash mode with those of the options that it has.

    Parameters
    ----------
    mode : str
        A key of `FLASH_MODES`.
    **options
        Those of all modes: max_pair_interval, registration, gate_px, frequency, frequencies, duty,
        frames, codes, frames_per_bit, bits_per_second, exposure.

    Returns
    -------
    Flash
        The mode, which has seen no frame.

    Raises
    ------
    ValueError
        If there is no such mode, or one of its options is invalid.
    TypeError
        An option is that of none of the modes.

    Examples
    --------
    A light that runs free at 13.7 Hz, on for half of each period:

    >>> flash = flash_by_name('periodic', frequency=13.7, duty=0.5)
    >>> flash.locked
    False
    >>> flash_by_name('blink')
    Traceback (most recent call last):
        ...
    ValueError: no flash mode 'blink'; there is alternate, steady, periodic, coded, lock_in, auto

    """
    if mode not in FLASH_MODES:
        raise ValueError(f"no flash mode '{mode}'; there is {', '.join(FLASH_MODES)}")
    every = {name for each in FLASH_MODES.values() for name in signature(each).parameters}
    unknown = sorted(options.keys() - every)
    if unknown:
        raise TypeError(
            f'no flash mode has {", ".join(unknown)}; there is {", ".join(sorted(every))}'
        )
    create = FLASH_MODES[mode]
    known = signature(create).parameters
    return create(**{name: value for name, value in options.items() if name in known})
