"""Controls of a V4L2 device: what there are, what they may be, and their values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
import ctypes
from dataclasses import dataclass
import errno
from math import isfinite
import re
from types import MappingProxyType
from typing import Any, Literal

from blob_tracker.capture import videodev2
from blob_tracker.capture.errors import CaptureError

Kind = Literal['integer', 'integer64', 'boolean', 'menu', 'integer_menu', 'bitmask', 'string',
               'button']
Ioctl = Callable[[int, Any], None]

_KINDS: Mapping[int, Kind] = MappingProxyType({
    videodev2.CTRL_TYPE_INTEGER: 'integer',
    videodev2.CTRL_TYPE_BOOLEAN: 'boolean',
    videodev2.CTRL_TYPE_MENU: 'menu',
    videodev2.CTRL_TYPE_BUTTON: 'button',
    videodev2.CTRL_TYPE_INTEGER64: 'integer64',
    videodev2.CTRL_TYPE_STRING: 'string',
    videodev2.CTRL_TYPE_BITMASK: 'bitmask',
    videodev2.CTRL_TYPE_INTEGER_MENU: 'integer_menu',
})
# First numbers of the classes of controls that webcams have: user and camera controls.
_CLASS_BASES = (0x00980900, 0x009a0900)
_STEPS_OVER = 32  # more than between the numbers of two that webcams have


class ControlError(CaptureError):
    """
    A control cannot be read or set; the message says which one and what it must be.

    Examples
    --------
    A gain that goes up to 100:

    >>> from blob_tracker.capture import V4l2Camera
    >>> with V4l2Camera('/dev/video0') as camera:  # doctest: +SKIP
    ...     camera.set_control('gain', 1000)
    Traceback (most recent call last):
        ...
    blob_tracker.capture.controls.ControlError: control 'gain' is 1000; it must be ...

    """


@dataclass(frozen=True)
class Control:
    """
    One control of a device, as the driver describes it at this moment.

    Parameters
    ----------
    number : int
        The kernel's number.
    name : str
        The driver's text as v4l2-ctl spells it: lower case, all between letters and digits one
        underscore.
    label : str
        The driver's text.
    kind : str
        What its values are: whole numbers ('integer' of 32 bits, 'integer64'), 0 or 1
        ('boolean'), a key of `menu` ('menu', 'integer_menu'), a set of the bits of `maximum`
        ('bitmask'), text ('string'), nothing ('button', which acts when it is set).
    minimum, maximum, step, default : int
        Range of the values; of a string, its length in bytes.
    menu : mapping of int to str
        Values of a menu and what they mean. Drivers leave values out: those are not allowed.
    read_only : bool
        Only the driver changes it.
    inactive : bool
        Without effect now, mostly as an automatic mode governs it.
    volatile : bool
        The driver changes it at any time.

    Examples
    --------
    A gain that has no effect now, as an automatic one governs it, and what it may be set to:

    >>> gain = Control(
    ...     0x00980913, 'gain', 'Gain', 'integer', minimum=0, maximum=100, step=1, default=0,
    ...     menu={}, read_only=False, inactive=True, volatile=False,
    ... )
    >>> gain.inactive, range(gain.minimum, gain.maximum + 1, gain.step)
    (True, range(0, 101))

    """

    number: int
    name: str
    label: str
    kind: Kind
    minimum: int
    maximum: int
    step: int
    default: int
    menu: Mapping[int, str]
    read_only: bool
    inactive: bool
    volatile: bool


def spelled(label: str) -> str:
    """Return a driver's text for a control as v4l2-ctl spells it."""
    return re.sub('[^a-z0-9]+', '_', label.lower()).strip('_')


def controls(ioctl: Ioctl, silent: dict[int, int] | None = None) -> dict[str, Control]:
    """
    Return all controls of a device in its own order: name -> control.

    Arrays and compound types (rectangles, codec tables) have no value that a person would type;
    they are left out, as are controls that the driver has disabled or fails to describe.

    Parameters
    ----------
    ioctl : function
        (number, argument) -> None: calls the driver, as `videodev2.ioctl` does, on the device.
    silent : dict of int to int, optional
        Remembers from call to call the controls that do not answer, each of which costs seconds:
        the number of the one before -> its own.

    Raises
    ------
    OSError
        ENODEV where the device is gone.

    """
    found: dict[str, Control] = {}
    for query in _queries(ioctl, {} if silent is None else silent):
        control = _described(ioctl, query)
        if control.name in found:  # drivers may give a text twice; the number tells them apart
            control = _described(ioctl, query, f'{control.name}_{control.number:08x}')
        found[control.name] = control
    return found


def get_control(ioctl: Ioctl, control: Control) -> int | str:
    """
    Return the value of a control: an int, or the text of a string.

    Raises
    ------
    ControlError
        It cannot be read.
    OSError
        ENODEV where the device is gone.

    """
    if control.kind == 'button':
        raise ControlError(f"control '{control.name}' cannot be read: it is a button, without a "
                           'value')
    argument = videodev2.ExtControl(id=control.number)
    if control.kind == 'string':
        text = ctypes.create_string_buffer(control.maximum + 1)
        argument.size, argument.value.string = len(text), ctypes.addressof(text)
        _transfer(ioctl, videodev2.G_EXT_CTRLS, argument, control, 'read')
        return text.value.decode(errors='replace')
    _transfer(ioctl, videodev2.G_EXT_CTRLS, argument, control, 'read')
    if control.kind == 'integer64':
        return int(argument.value.value64)
    value = int(argument.value.value)
    return value & 0xffffffff if control.kind == 'bitmask' else value


def set_control(ioctl: Ioctl, control: Control, value: int | bool | float | str) -> None:
    """
    Set a control; others may change with it, in their values, ranges and flags.

    Parameters
    ----------
    ioctl : function
        As that of `controls`.
    control : Control
        As the driver describes it now.
    value : int, bool, float or str
        A whole number within the range, in its steps; of a menu a value or its text; of a
        boolean True, False, 1 or 0; True presses a button.

    Raises
    ------
    ControlError
        The value is not one that the control may have, or the driver does not allow it now.
    OSError
        ENODEV where the device is gone.

    """
    if control.read_only:
        raise ControlError(f"control '{control.name}' is read-only: the driver alone changes it")
    argument = videodev2.ExtControl(id=control.number)
    if control.kind == 'string':
        # Kept until the driver has read it: the struct holds a bare address.
        text = ctypes.create_string_buffer(_checked_text(control, value), control.maximum + 1)
        argument.size, argument.value.string = len(text), ctypes.addressof(text)
    elif control.kind == 'integer64':
        argument.value.value64 = _checked(control, value)
    else:
        argument.value.value = _checked(control, value)  # ctypes wraps a bitmask's top bit
    _transfer(ioctl, videodev2.S_EXT_CTRLS, argument, control, 'set')


# --- what there is ---


def _queries(ioctl: Ioctl, silent: dict[int, int]) -> Iterator[videodev2.QueryExtCtrl]:
    """Yield the driver's description of each control that has one of the kinds."""
    last = 0
    while True:
        query = _next(ioctl, last, silent)
        if query is None or query.id <= last:
            return  # a driver that does not know the flag gives the same one for ever
        last = query.id
        if query.type in _KINDS and not query.flags & videodev2.CTRL_FLAG_DISABLED:
            yield query


def _next(ioctl: Ioctl, last: int, silent: dict[int, int]) -> videodev2.QueryExtCtrl | None:
    """Return the driver's description of the next control that it can describe, if any."""
    while True:
        while last in silent:
            last = silent[last]
        query = videodev2.QueryExtCtrl(id=last | videodev2.CTRL_FLAG_NEXT_CTRL)
        # A webcam may fail to answer for one control (EIO, EPIPE, after seconds ETIMEDOUT).
        failed = _failure(ioctl, query)
        if not failed:
            return query
        if failed in (errno.EINVAL, errno.ENOTTY):
            return None  # no more; no controls at all
        for number in _numbers_behind(last):
            query = videodev2.QueryExtCtrl(id=number)
            failed = _failure(ioctl, query)
            if not failed:
                return query
            if failed != errno.EINVAL:
                break
        else:
            return None
        if failed == errno.ETIMEDOUT:
            silent[last] = number
        last = number


def _numbers_behind(last: int) -> Iterator[int]:
    """Yield the numbers that a webcam's next control may have."""
    for first in (last + 1, *(base for base in _CLASS_BASES if base > last)):
        yield from range(first, first + _STEPS_OVER)


def _failure(ioctl: Ioctl, query: videodev2.QueryExtCtrl) -> int:
    """Let the driver describe a control; return the error's number, 0 where it does."""
    try:
        ioctl(videodev2.QUERY_EXT_CTRL, query)
    except OSError as error:
        if error.errno == errno.ENODEV:
            raise
        return error.errno or errno.EIO
    return 0


def _described(ioctl: Ioctl, query: videodev2.QueryExtCtrl, name: str = '') -> Control:
    label = query.name.decode(errors='replace')
    kind = _KINDS[query.type]
    unsigned = 0xffffffff if kind == 'bitmask' else -1  # some drivers extend the sign
    return Control(
        number=query.id,
        name=name or spelled(label),
        label=label,
        kind=kind,
        minimum=query.minimum,
        maximum=query.maximum & unsigned,
        step=query.step or 1,
        default=query.default_value & unsigned,
        menu=MappingProxyType(_menu(ioctl, query) if 'menu' in kind else {}),
        read_only=bool(query.flags & videodev2.CTRL_FLAG_READ_ONLY),
        inactive=bool(query.flags & videodev2.CTRL_FLAG_INACTIVE),
        volatile=bool(query.flags & videodev2.CTRL_FLAG_VOLATILE),
    )


def _menu(ioctl: Ioctl, query: videodev2.QueryExtCtrl) -> dict[int, str]:
    """Return the items of a menu that the driver has: it refuses those that it lacks."""
    items = {}
    for index in range(query.minimum, query.maximum + 1):
        item = videodev2.QueryMenu(id=query.id, index=index)
        try:
            ioctl(videodev2.QUERYMENU, item)
        except OSError as error:
            if error.errno == errno.ENODEV:
                raise
            continue
        if query.type == videodev2.CTRL_TYPE_INTEGER_MENU:
            items[index] = str(item.item.value)
        else:
            items[index] = item.item.name.decode(errors='replace')
    return items


# --- values ---


def must_be(control: Control) -> str:
    """Return in words what a control may be."""
    if control.kind == 'boolean':
        return 'true or false'
    if control.kind == 'button':
        return 'true, which presses it'
    if control.menu:
        return 'one of ' + ', '.join(
            f'{value} ({text})' for value, text in control.menu.items())
    if control.kind == 'bitmask':
        return f'a whole number whose bits are among those of {control.maximum:#x}'
    steps = f' in steps of {control.step}' if control.step != 1 else ''
    if control.kind == 'string':
        return f'a text of {control.minimum} to {control.maximum} bytes{steps}'
    return f'a whole number from {control.minimum} to {control.maximum}{steps}'


def _wrong(control: Control, value: object) -> ControlError:
    return ControlError(f"control '{control.name}' is {value!r}; it must be {must_be(control)}")


def _checked(control: Control, value: int | bool | float | str) -> int:
    """Return the number that the driver takes for a value."""
    number = next((item for item, text in control.menu.items() if text == value), value)
    if not isinstance(number, (int, float)) or not isfinite(number):
        raise _wrong(control, value)
    whole = int(number)
    if control.kind in ('boolean', 'button'):
        allowed = number in ((0, 1) if control.kind == 'boolean' else (1,))
    elif isinstance(number, bool) or whole != number:
        allowed = False
    elif 'menu' in control.kind:
        allowed = whole in control.menu
    elif control.kind == 'bitmask':
        allowed = whole >= 0 and not whole & ~control.maximum
    else:
        allowed = (control.minimum <= whole <= control.maximum
                   and (whole - control.minimum) % control.step == 0)
    if not allowed:
        raise _wrong(control, value)
    return whole


def _checked_text(control: Control, value: object) -> bytes:
    if not isinstance(value, str):
        raise _wrong(control, value)
    text = value.encode()
    if not (control.minimum <= len(text) <= control.maximum
            and (len(text) - control.minimum) % control.step == 0 and b'\0' not in text):
        raise _wrong(control, value)
    return text


def _transfer(
    ioctl: Ioctl, number: int, argument: videodev2.ExtControl, control: Control, verb: str,
) -> None:
    request = videodev2.ExtControls(count=1, controls=ctypes.pointer(argument))
    try:
        ioctl(number, request)
    except OSError as error:
        if error.errno == errno.ENODEV:
            raise
        raise ControlError(f"control '{control.name}' cannot be {verb}"
                           f'{_why(control, error, verb)}') from error


def _why(control: Control, error: OSError, verb: str) -> str:
    if error.errno == errno.EACCES and verb == 'read':
        return ': it is write-only'
    if control.inactive and error.errno in (errno.EACCES, errno.EIO, errno.EINVAL, errno.EBUSY):
        return (' while it is inactive: another control, mostly an automatic mode, governs it; '
                'switch that off first')
    if error.errno == errno.EBUSY:
        return ' now: the driver locks it while frames are streaming or another program holds it'
    if error.errno in (errno.EINVAL, errno.ERANGE):
        return f': the driver refuses the value; it must be {must_be(control)}'
    return f': {error.strerror}'
