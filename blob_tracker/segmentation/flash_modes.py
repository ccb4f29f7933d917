"""The ways in which a light may flash, by name."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature

from blob_tracker.segmentation.auto import Auto
from blob_tracker.segmentation.blink import Coded, Periodic
from blob_tracker.segmentation.flash import Flash
from blob_tracker.segmentation.in_step import InStep
from blob_tracker.segmentation.lock_in import LockIn
from blob_tracker.segmentation.several import AlternateLights, SteadyLights
from blob_tracker.segmentation.steady import Steady

FLASH_MODES: dict[str, Callable[..., Flash]] = {
    'alternate': InStep,
    'steady': Steady,
    'periodic': Periodic,
    'coded': Coded,
    'lock_in': LockIn,
    'auto': Auto,
}
# With more than one light.
SEVERAL: dict[str, Callable[..., Flash]] = {'alternate': AlternateLights, 'steady': SteadyLights}


def flash_by_name(mode: str, **options: object) -> Flash:
    """
    Return a flash mode with those of the options that it has.

    Parameters
    ----------
    mode : str
        A key of `FLASH_MODES`.
    **options
        Those of all modes: max_pair_interval, registration, gate_px, frequency, frequencies, duty,
        frames, codes, frames_per_bit, bits_per_second, exposure, lights.

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
    makers = (*FLASH_MODES.values(), *SEVERAL.values())
    every = {name for each in makers for name in signature(each).parameters}
    unknown = sorted(options.keys() - every)
    if unknown:
        raise TypeError(
            f'no flash mode has {", ".join(unknown)}; there is {", ".join(sorted(every))}'
        )
    create, lights = FLASH_MODES[mode], options.get('lights', 1)
    if lights != 1:
        if mode not in SEVERAL:
            raise ValueError(
                f"lights is {lights}; it must be 1 with mode '{mode}': several lights without "
                f'names are those of {" and ".join(SEVERAL)}'
            )
        create = SEVERAL[mode]
    known = signature(create).parameters
    return create(**{name: value for name, value in options.items() if name in known})
