"""The controls of a camera as parameters of its node."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from threading import Lock
from typing import Any

from blob_tracker.capture import CaptureError, Control, ControlError, V4l2Camera
from blob_tracker.capture.auto_modes import off, still_on
from blob_tracker.capture.controls import must_be
from blob_tracker.capture.exposure import adjust_exposure, put_back
from blob_tracker.capture.exposure_search import Outcome
from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters.values import unknown
from blob_tracker.types import Frame
from rcl_interfaces.msg import (
    IntegerRange, ParameterDescriptor, ParameterType, SetParametersResult,
)
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter

REFRESH_S = 1.0  # s between two looks at what the driver or another program has changed
_MODES = ('boolean', 'menu', 'integer_menu')  # they may decide whether another control is active
_TYPES = {
    'boolean': ParameterType.PARAMETER_BOOL,
    'button': ParameterType.PARAMETER_BOOL,
    'string': ParameterType.PARAMETER_STRING,
}
# Names that Linux gave two controls until 5.16, and those since.
RENAMED = {
    'exposure_auto': 'auto_exposure',
    'white_balance_temperature_auto': 'white_balance_automatic',
}


def parameter_value(control: Control, value: int | str) -> bool | int | str:
    """Return the value of a control as that of its parameter."""
    return bool(value) if control.kind in ('boolean', 'button') else value


def descriptor(control: Control, value: bool | int | str) -> ParameterDescriptor:
    """
    Return what `ros2 param describe` and rqt show of a control.

    A menu is an integer, as v4l2-ctl and the other camera nodes have it, with its items in the
    description: their texts differ from driver to driver, their numbers do not. A read-only
    control is no read-only parameter, since those may never change and the driver changes it.

    Parameters
    ----------
    control : Control
        As the driver describes it.
    value : bool, int or str
        Its value. The range is left out where it does not hold it, as some drivers have it;
        they judge by themselves then.

    """
    words = [f'{control.label}:', must_be(control) + ';']
    if control.kind not in ('string', 'button'):
        default = parameter_value(control, control.default)
        words.append(f'{str(default).lower()} by default.')
    elif control.kind == 'button':
        words[-1] = 'true presses it.'
    if control.read_only:
        words.append('Read-only.')
    if control.inactive:
        words.append('Inactive: an automatic mode governs it.')
    described = ParameterDescriptor(
        name=control.name,
        type=_TYPES.get(control.kind, ParameterType.PARAMETER_INTEGER),
        description=' '.join(words).rstrip(';'),
    )
    if described.type == ParameterType.PARAMETER_INTEGER:
        assert isinstance(value, int)
        # A bitmask begins at 0, and the step of a menu says nothing of its gaps.
        step = 1 if control.menu or control.kind == 'bitmask' else control.step
        within = control.minimum <= value <= control.maximum
        if within and (value == control.maximum or (value - control.minimum) % step == 0):
            described.integer_range = [
                IntegerRange(from_value=control.minimum, to_value=control.maximum, step=step)
            ]
    return described


def set_in_order(
    camera: V4l2Camera, known: Mapping[str, Control], values: Mapping[str, Any]
) -> Iterator[tuple[str, ControlError | None]]:
    """
    Set controls one after the other, the modes before what they make active.

    Any control may widen the range of another or make it active, the blanking that of the
    exposure, say: what is refused is tried again as long as something else could be set.

    Parameters
    ----------
    camera : V4l2Camera
        Open.
    known : mapping of str to Control
        Its controls by name, as they are now.
    values : mapping
        Value by the control's name.

    Yields
    ------
    str, ControlError or None
        The name of each and why the camera refused it; the refused ones come last.

    Raises
    ------
    CaptureError
        The camera is gone.

    """
    modes = [name for name in values if name in known and known[name].kind in _MODES]
    turns = [modes, [name for name in values if name not in modes]]
    rejected: dict[str, ControlError] = {}
    stale = False  # whether something was set since the camera was asked for its controls
    while turns:
        moved = False
        for turn in turns:
            if stale and turn:
                known, stale = camera.controls, False
            for name in turn:
                error = _rejection(camera, known.get(name, name), values[name])
                if error is not None:
                    rejected[name] = error
                    continue
                moved = stale = True
                rejected.pop(name, None)
                yield name, None
        turns = [list(rejected)] if moved and rejected else []
    yield from rejected.items()


def _rejection(camera: V4l2Camera, control: Control | str, value: Any) -> ControlError | None:
    if isinstance(control, Control) and control.inactive:
        return ControlError(
            f"control '{control.name}' is inactive: an automatic mode governs it; switch that off "
            'first'
        )
    try:
        camera.set_control(control, value)
    except ControlError as error:
        return error
    return None


class ControlParameters:
    """
    Parameters that are the controls of whichever camera is open.

    Two threads meet here. The one that captures calls `prepare`, `attach` and `detach`; all that
    touches the node's parameters runs in its executor, as rclpy's are not safe among threads: a
    guard condition calls it there. Neither waits for the other, and what the executor asks of a
    camera that is closed meanwhile ends in a CaptureError.

    What was set by the user, at the start or later, is set again on each camera that is opened.
    What a driver changes by itself, or another program, is shown and left alone.

    Parameters
    ----------
    node : Node
        Gets the parameters when a camera is there.
    given : mapping
        Values by name that start-up gave to parameters that only a camera can have.
    health : Health
        Shows the automatic modes.
    from_files : collection of str
        Those of the values that a file gives: `ros2 param dump` writes down all that is shown, so
        that of controls that are read-only or inactive, too, which is no fault.

    Attributes
    ----------
    warnings : tuple of str
        What is wrong with the controls now, a sentence each.

    """

    def __init__(
        self, node: Node, given: Mapping[str, Any], health: Health,
        from_files: Collection[str] = (),
    ) -> None:
        self.warnings: tuple[str, ...] = ()
        self._node = node
        self._health = health
        self._own = node.list_parameters([], 0).names
        self._wanted = dict(given)
        self._from_files = set(from_files)
        self._lock = Lock()  # of what is wanted, which both threads change
        for name, value in given.items():
            if not isinstance(value, (bool, int, float, str)):
                raise ParameterError(
                    f"parameter '{name}' is {value!r}; a control of the camera has one number, "
                    'true or false, or one text'
                )
        self._camera: V4l2Camera | None = None
        self._met = False  # whether a camera has taken what start-up gave
        self._wrong: ParameterError | None = None
        self._rejected: tuple[str, ...] = ()
        self._shown: dict[str, ParameterDescriptor] = {}
        self._restless: list[Control] = []  # may change without the driver's telling
        self._seen = 0  # of the changes that the driver told of
        self._mirroring = False
        self._changed = node.create_guard_condition(self._mirror)
        # Wall time, as a paused simulation does not pause a camera.
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(REFRESH_S, self._refresh, clock=clock)
        node.add_on_set_parameters_callback(self._set)

    # --- called by the thread that captures ---

    def prepare(self, camera: V4l2Camera) -> None:
        """
        Set what the user wants on a camera that was just opened; exposure and gain are fixed.

        Raises
        ------
        ParameterError
            The first camera lacks a control that start-up named, or refuses its value. The same
            error ends the executor, and so the node.
        CaptureError
            The camera is gone.

        """
        known = camera.controls
        wanted = dict(self._wanted)  # the executor may add to it
        try:
            for name in wanted:
                if name not in known and not self._met:
                    if (today := RENAMED.get(name)) in known:
                        raise ParameterError(f"no parameter '{name}'; it is '{today}' today")
                    raise unknown(name, [*self._own, *known])
            wanted = self._without_idle(wanted, known)
            rejected = []
            fixed = {name: value for name, value in off(known).items() if name not in wanted}
            for name, error in set_in_order(camera, known, fixed | wanted):
                if error is None:
                    continue
                if name in self._from_files and _is_inactive(camera, name):
                    continue
                if name in wanted and not self._met:
                    raise ParameterError(f"parameter '{name}': {error}")
                if name in known and known[name].inactive:
                    continue  # it has no effect, and nobody asks for it now
                rejected.append(str(error))
        except ParameterError as error:
            self._wrong = error
            self._changed.trigger()
            raise
        self._rejected = tuple(rejected)
        # A button is pressed once, not whenever the camera returns.
        buttons = {name for name, control in known.items() if control.kind == 'button'}
        with self._lock:
            self._wanted = {
                name: value for name, value in self._wanted.items() if name not in buttons
            }
        self._met = True

    def _without_idle(
        self, wanted: Mapping[str, Any], known: Mapping[str, Control]
    ) -> dict[str, Any]:
        """Return what is wanted less what a file tells of controls that cannot be set now."""
        return {
            name: value for name, value in wanted.items()
            if name not in self._from_files or name not in known
            or not (known[name].read_only or (known[name].kind == 'button' and not value))
        }

    def attach(self, camera: V4l2Camera) -> None:
        """Make the parameters those of this camera."""
        self._camera = camera
        self._changed.trigger()

    def detach(self) -> None:
        """Refuse every change until the next camera is there; the parameters stay."""
        self._camera = None
        self.warnings = ()

    def adjust_exposure(
        self, camera: V4l2Camera, read: Callable[[], Frame], channel: str
    ) -> Outcome:
        """
        Search for the exposure and gain of a lit target; keep what was found as if it were set.

        Parameters
        ----------
        camera : V4l2Camera
            Open and streaming.
        read : function
            Returns its next frame.
        channel : str
            The colour of the light, see `blob_tracker.capture.exposure`.

        Raises
        ------
        CaptureError
            The camera has neither control, or fails meanwhile.

        """
        try:
            outcome = adjust_exposure(camera, read, channel=channel)
        finally:
            self._changed.trigger()  # also where it was broken off, and put back
        with self._lock:
            self._wanted = self._wanted | dict(outcome.controls)
        return outcome

    # --- called by the executor ---

    def _set(self, parameters: list[Parameter]) -> SetParametersResult:
        """Set the controls among the parameters: all of them or none."""
        values = {p.name: p.value for p in parameters if p.name in self._shown}
        if self._mirroring or not values:
            return SetParametersResult(successful=True)
        camera = self._camera
        if camera is None:
            return _rejected(f"'{next(iter(values))}' is a control of the camera, which is not "
                             'there; see /diagnostics')
        try:
            known = camera.controls
            before = _values(camera, [known[name] for name in values if name in known])
            done: list[str] = []
            for name, error in set_in_order(camera, known, values):
                if error is not None:
                    put_back(camera, {each: before[each] for each in done})
                    return _rejected(str(error))
                if name in before:  # a button cannot be released
                    done.append(name)
        except CaptureError as error:
            return _rejected(str(error))
        finally:
            # Buttons spring back, and others may have changed with it, refused or not.
            self._changed.trigger()
        with self._lock:
            self._wanted = self._wanted | {name: values[name] for name in done}
        return SetParametersResult(successful=True)

    def _refresh(self) -> None:
        """Show what changed by itself: all of it takes a hundred calls of the driver."""
        camera = self._camera
        if camera is None:
            return
        if camera.control_changes != self._seen or not camera.tells_changes:
            self._mirror()
            return
        try:
            values = _values(camera, self._restless)
        except CaptureError:
            return  # whoever captures meets it as well, and says it
        self._mirroring = True
        try:
            for control in self._restless:
                if control.name in self._shown and control.name in values:
                    self._show(control, values[control.name])
        finally:
            self._mirroring = False

    def _mirror(self) -> None:
        """Show the controls as the camera has them."""
        if self._wrong is not None:
            raise self._wrong
        camera = self._camera
        if camera is None:
            return
        seen = camera.control_changes  # before it is read: what changes meanwhile is read again
        try:
            controls = camera.controls
            values = _values(camera, controls.values())
        except CaptureError:
            return  # whoever captures meets it as well, and says it
        self._seen = seen
        self._mirroring = True
        try:
            for name in [name for name in self._shown if name not in controls]:
                self._node.undeclare_parameter(name)
                del self._shown[name]
            for name, control in controls.items():
                if name and name not in self._own:
                    self._show(control, values.get(name, _unread(control)))
        finally:
            self._mirroring = False
        self._restless = [
            control for control in controls.values() if control.volatile or control.inactive
        ]
        automatic = still_on(controls, values)
        self._health.show('automatic modes on', ', '.join(automatic) or 'none')
        self.warnings = (*self._rejected, *automatic.values())

    def _show(self, control: Control, value: int | str) -> None:
        """Declare the parameter of a control, or bring it up to date."""
        name, shown = control.name, parameter_value(control, value)
        described = descriptor(control, shown)
        if self._shown.get(name) == described:
            if self._node.get_parameter(name).value != shown:
                self._node.set_parameters([Parameter(name, value=shown)])
            return
        if name in self._shown:
            self._node.undeclare_parameter(name)
        self._node.declare_parameter(name, shown, described, ignore_override=True)
        self._shown[name] = described


def _is_inactive(camera: V4l2Camera, name: str) -> bool:
    """Tell whether an automatic mode governs a control, as the camera has it now."""
    control = camera.controls.get(name)
    return control is not None and control.inactive


def _rejected(reason: str) -> SetParametersResult:
    return SetParametersResult(successful=False, reason=reason)


def _unread(control: Control) -> int | str:
    """Return what stands for the value of a control that cannot be read."""
    return '' if control.kind == 'string' else 0 if control.kind == 'button' else control.default


def _values(camera: V4l2Camera, controls: Iterable[Control]) -> dict[str, int | str]:
    """Return the values of those controls that can be read."""
    found = {}
    for control in controls:
        try:
            found[control.name] = camera.get_control(control)
        except ControlError:
            pass  # a button, or write-only
    return found
