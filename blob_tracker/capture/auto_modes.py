"""Modes in which a camera changes its exposure and gain by itself, and their ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Control

EXPOSURE_AUTO = videodev2.CID_EXPOSURE_AUTO
EXPOSURES = videodev2.CID_EXPOSURE, videodev2.CID_EXPOSURE_ABSOLUTE
# The kernel's number of the control -> the value with which nothing moves by itself.
_OFF = {
    EXPOSURE_AUTO: 1,  # V4L2_EXPOSURE_MANUAL
    0x009a0903: 0,  # V4L2_CID_EXPOSURE_AUTO_PRIORITY: the frame rate is not lowered in the dark
    0x009a0918: 0,  # V4L2_CID_ISO_SENSITIVITY_AUTO: V4L2_ISO_SENSITIVITY_MANUAL
    0x00980912: 0,  # V4L2_CID_AUTOGAIN
    0x00980920: 0,  # V4L2_CID_AUTOBRIGHTNESS
}


def off(controls: Mapping[str, Control]) -> dict[str, int]:
    """
    Return what switches off every mode in which the brightness of the picture moves by itself.

    Such a mode answers a flash with another exposure: the lit and the unlit frame are no longer
    comparable. A mode that has no such setting is not in the answer; see `still_on`.

    Parameters
    ----------
    controls : mapping of str to Control
        All controls of the camera by name.

    Returns
    -------
    dict
        Value by the control's name.

    """
    return {
        name: _OFF[control.number]
        for name, control in controls.items()
        if control.number in _OFF
        and not control.read_only
        and (not control.menu or _OFF[control.number] in control.menu)
    }


def still_on(controls: Mapping[str, Control], values: Mapping[str, int | str]) -> dict[str, str]:
    """
    Return the modes that are on: the control's name -> a sentence with the remedy.

    Parameters
    ----------
    controls : mapping of str to Control
        All controls of the camera by name.
    values : mapping of str to int or str
        Their values by name.

    """
    found = {}
    settings = off(controls)
    for name, control in controls.items():
        neutral = _OFF.get(control.number)
        if neutral is None or values.get(name, neutral) == neutral:
            continue
        if control.inactive and control.number == 0x009a0903:
            continue  # only an automatic exposure lowers the rate
        value = int(values[name])
        meaning = f' ({control.menu[value]})' if value in control.menu else ''
        remedy = (
            f"set '{name}' to {_spelled(control, settings[name])}"
            if name in settings
            else 'it cannot be switched off here: use a camera with a manual exposure'
        )
        found[name] = (
            f"'{name}' is {_spelled(control, value)}{meaning}: the camera changes its exposure by "
            f'itself, and lit and unlit frames do not compare; {remedy}'
        )
    found |= {
        control.name: f"'{control.name}' is inactive: a mode that the camera does not show "
                      'governs it, and lit and unlit frames may not compare; use a camera whose '
                      "'auto_exposure' can be read"
        for control in governed_exposures(controls.values())
    }
    return found


def governed_exposures(controls: Iterable[Control]) -> list[Control]:
    """Return the exposure times that a mode chooses of which the device does not tell."""
    known = {control.number: control for control in controls}
    if EXPOSURE_AUTO in known:
        return []
    return [known[number] for number in EXPOSURES if number in known and known[number].inactive]


def _spelled(control: Control, value: int) -> str:
    """Return a value as its parameter is written."""
    return str(bool(value)).lower() if control.kind == 'boolean' else str(value)
