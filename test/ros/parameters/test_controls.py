"""A V4L2 control as a ROS parameter; on a real driver in test/vm/test_node.py."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from blob_tracker.capture import CaptureError, Control, ControlError
from blob_tracker.capture.auto_modes import off, still_on
from blob_tracker.capture.controls import must_be
from blob_tracker.capture.exposure_search import Outcome
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters.controls import (
    ControlParameters, descriptor, parameter_value, set_in_order)
import pytest
from rcl_interfaces.msg import IntegerRange, ParameterType
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

GAIN = Control(
    number=0x00980913, name='gain', label='Gain', kind='integer', minimum=-8, maximum=254, step=2,
    default=100, menu={}, read_only=False, inactive=False, volatile=False,
)
AUTO_EXPOSURE = replace(
    GAIN, number=0x009a0901, name='auto_exposure', label='Auto Exposure', kind='menu', minimum=0,
    maximum=3, step=1, default=3, menu={1: 'Manual Mode', 3: 'Aperture Priority Mode'},
)
AUTO_GAIN = replace(
    GAIN, number=0x00980912, name='gain_automatic', label='Gain, Automatic', kind='boolean',
    minimum=0, maximum=1, step=1, default=1,
)
FRAMERATE = replace(
    AUTO_GAIN, number=0x009a0903, name='exposure_dynamic_framerate',
    label='Exposure, Dynamic Framerate',
)


def control(**changes: Any) -> Control:
    """Return the gain with something changed."""
    return replace(GAIN, **changes)


@pytest.mark.parametrize('kind, raw, value, ros_type', [
    ('integer', 10, 10, ParameterType.PARAMETER_INTEGER),
    ('integer64', 10, 10, ParameterType.PARAMETER_INTEGER),
    ('boolean', 1, True, ParameterType.PARAMETER_BOOL),
    ('button', 0, False, ParameterType.PARAMETER_BOOL),
    ('bitmask', 6, 6, ParameterType.PARAMETER_INTEGER),
    ('string', 'abc', 'abc', ParameterType.PARAMETER_STRING),
])
def test_each_kind_has_its_type(kind: str, raw: int | str, value: object, ros_type: int) -> None:
    """The value has the type that the descriptor says."""
    given = control(kind=kind)
    shown = parameter_value(given, raw)
    assert shown == value and type(shown) is type(value)
    assert descriptor(given, shown).type == ros_type


def test_an_integer_has_its_range_and_step() -> None:
    """And its description has the driver's text, the range and the default."""
    described = descriptor(GAIN, 10)
    assert described.name == 'gain'
    assert described.integer_range == [IntegerRange(from_value=-8, to_value=254, step=2)]
    assert described.description == (
        'Gain: a whole number from -8 to 254 in steps of 2; 100 by default.'
    )
    assert not described.read_only


def test_64_bits_fit() -> None:
    """The range of an integer64 is that of the parameter's own type."""
    described = descriptor(control(kind='integer64', minimum=-2**63, maximum=2**63 - 1, step=1), 0)
    assert described.integer_range == [
        IntegerRange(from_value=-2**63, to_value=2**63 - 1, step=1)
    ]


@pytest.mark.parametrize('value', [-10, 256, 11])
def test_a_range_that_does_not_hold_its_own_value_is_left_out(value: int) -> None:
    """As rclpy refuses to declare such a parameter; the driver judges what is set."""
    assert not descriptor(GAIN, value).integer_range


def test_the_upper_end_may_lie_off_the_steps() -> None:
    """Both rclpy and the kernel take it."""
    assert descriptor(control(maximum=255), 255).integer_range


def test_a_menu_is_an_integer_with_its_items_in_words() -> None:
    """The numbers are those of v4l2-ctl."""
    described = descriptor(AUTO_EXPOSURE, 3)
    assert described.type == ParameterType.PARAMETER_INTEGER
    assert described.integer_range == [IntegerRange(from_value=0, to_value=3, step=1)]
    assert described.description == (
        'Auto Exposure: one of 1 (Manual Mode), 3 (Aperture Priority Mode); 3 by default.'
    )


def test_a_bitmask_may_have_any_of_its_bits() -> None:
    """Its step, which a driver leaves at 0 or 1, is no step."""
    described = descriptor(control(kind='bitmask', minimum=0, maximum=0x80002000, step=1), 0x2000)
    assert described.integer_range == [
        IntegerRange(from_value=0, to_value=0x80002000, step=1)
    ]


@pytest.mark.parametrize('changes, words', [
    ({'read_only': True}, 'Read-only.'),
    ({'inactive': True}, 'Inactive: an automatic mode governs it.'),
    ({'kind': 'button'}, 'Gain: true presses it.'),
    ({'kind': 'string', 'minimum': 0, 'maximum': 32, 'step': 1},
     'Gain: a text of 0 to 32 bytes'),
])
def test_what_is_special_is_in_the_description(changes: dict[str, Any], words: str) -> None:
    """A parameter that the driver changes is not read-only to ROS, so the words say it."""
    given = control(**changes)
    described = descriptor(given, '' if given.kind == 'string' else 0)
    assert words in described.description
    assert not described.read_only


def test_all_automatic_modes_are_switched_off() -> None:
    """Exposure to manual, which is 1 in the kernel's menu; the others to 0."""
    modes = {c.name: c for c in (GAIN, AUTO_EXPOSURE, AUTO_GAIN, FRAMERATE)}
    assert off(modes) == {
        'auto_exposure': 1, 'gain_automatic': 0, 'exposure_dynamic_framerate': 0
    }


def test_a_mode_that_cannot_be_off_is_left_and_told() -> None:
    """No manual entry in the menu, or a control that is read-only."""
    modes = {
        'auto_exposure': replace(AUTO_EXPOSURE, menu={3: 'Aperture Priority Mode'}),
        'gain_automatic': replace(AUTO_GAIN, read_only=True),
    }
    assert off(modes) == {}
    told = still_on(modes, {'auto_exposure': 3, 'gain_automatic': 1})
    assert told['auto_exposure'].startswith("'auto_exposure' is 3 (Aperture Priority Mode): ")
    assert "'gain_automatic' is true: " in told['gain_automatic']
    assert all('it cannot be switched off here' in sentence for sentence in told.values())


def test_a_mode_that_is_on_is_told_with_the_remedy() -> None:
    """The sentence has the value to set."""
    told = still_on({'auto_exposure': AUTO_EXPOSURE}, {'auto_exposure': 3})
    assert told['auto_exposure'].endswith("set 'auto_exposure' to 1")
    told = still_on({'gain_automatic': AUTO_GAIN}, {'gain_automatic': 1})
    assert told['gain_automatic'].endswith("set 'gain_automatic' to false")
    assert not still_on({'gain_automatic': AUTO_GAIN}, {'gain_automatic': 0})


def test_a_frame_rate_that_only_an_automatic_exposure_lowers_is_not_told() -> None:
    """With a manual exposure drivers make that control inactive and keep its value."""
    inactive = {FRAMERATE.name: replace(FRAMERATE, inactive=True)}
    assert not still_on(inactive, {FRAMERATE.name: 1})


EXPOSURE = replace(
    GAIN, number=0x00980911, name='exposure', label='Exposure', minimum=1, maximum=1000, step=1,
)


def test_an_exposure_that_a_hidden_mode_governs_is_told() -> None:
    """A webcam may fail to tell of its auto_exposure."""
    assert not still_on({'exposure': EXPOSURE}, {'exposure': 5})
    governed = {'exposure': replace(EXPOSURE, inactive=True)}
    assert "'exposure' is inactive: a mode" in still_on(governed, {'exposure': 5})['exposure']
    governed['auto_exposure'] = AUTO_EXPOSURE
    assert list(still_on(governed, {'exposure': 5, 'auto_exposure': 3})) == ['auto_exposure']


BLANKING = replace(
    GAIN, number=0x009e0901, name='vertical_blanking', label='Vertical Blanking', minimum=10,
    maximum=10000, step=1,
)
ISO_AUTO = replace(
    AUTO_EXPOSURE, number=0x009a0918, name='iso_sensitivity_auto', label='ISO Sensitivity, Auto',
    maximum=1, default=1, menu={0: 'Manual', 1: 'Auto'},
)
ISO = replace(
    AUTO_EXPOSURE, number=0x009a0917, name='iso_sensitivity', label='ISO Sensitivity',
    kind='integer_menu', maximum=2, default=0, menu={0: '100', 1: '200', 2: '400'},
)


class FakeCamera:
    """
    Controls that govern each other, as those of real drivers do.

    The exposure must fit into the vertical blanking, which cuts it where it is made shorter; an
    automatic mode makes what it governs inactive.
    """

    control_changes = 0
    GOVERNED = {
        'exposure_time_absolute': ('auto_exposure', 1), 'iso_sensitivity': (ISO_AUTO.name, 0),
    }

    def __init__(self, *controls: Control, **values: int) -> None:
        self.all = {each.name: each for each in controls}
        self.values = {each.name: each.default for each in controls} | values
        self.log: list[tuple[str, Any]] = []

    @property
    def controls(self) -> dict[str, Control]:
        """Return the controls as they are now."""
        found = dict(self.all)
        if 'exposure' in found and 'vertical_blanking' in found:
            found['exposure'] = replace(EXPOSURE, maximum=self.values['vertical_blanking'])
        for name, (mode, manual) in self.GOVERNED.items():
            if name in found and mode in found:
                found[name] = replace(found[name], inactive=self.values[mode] != manual)
        return found

    def get_control(self, control: Control | str) -> int:
        """Return a value."""
        return self.values[control if isinstance(control, str) else control.name]

    def set_control(self, control: Control | str, value: int) -> None:
        """Set a value, or refuse it by what the caller knows of the control and by what it is."""
        name = control if isinstance(control, str) else control.name
        if name not in self.all:
            raise ControlError(f"there is no control '{name}'")
        now = self.controls[name]
        for known in (now, control):
            if isinstance(known, Control) and (
                known.read_only or known.inactive
                or not known.minimum <= value <= known.maximum
                or (known.menu and value not in known.menu)
            ):
                raise ControlError(f"control '{name}' is {value!r}; it must be {must_be(known)}")
        self.values[name] = value
        self.log.append((name, value))
        if name == 'vertical_blanking' and 'exposure' in self.values:
            self.values['exposure'] = min(self.values['exposure'], value)


@pytest.mark.parametrize('values', [
    {'vertical_blanking': 5000, 'exposure': 4000},
    {'exposure': 4000, 'vertical_blanking': 5000},
    {'iso_sensitivity': 1, 'iso_sensitivity_auto': 0},
    {'iso_sensitivity_auto': 0, 'iso_sensitivity': 1},
    {'exposure': 4000, 'iso_sensitivity': 2, 'vertical_blanking': 5000, ISO_AUTO.name: 0},
])
def test_a_control_that_another_makes_possible_is_set_in_any_order(values: dict[str, int]) -> None:
    """The range of the exposure is the blanking's, and a menu may be governed by a menu."""
    camera: Any = FakeCamera(
        EXPOSURE, BLANKING, ISO, ISO_AUTO, exposure=500, vertical_blanking=1000
    )
    assert set(set_in_order(camera, camera.controls, values)) == {
        (name, None) for name in values}
    assert camera.values == camera.values | values
    assert len(camera.log) == len(values)  # each once


def test_refusals_come_last_and_end() -> None:
    """Modes first; what is still refused when nothing else moves is told, each once."""
    camera: Any = FakeCamera(
        EXPOSURE, BLANKING, ISO, ISO_AUTO, exposure=500, vertical_blanking=1000
    )
    values = {'nothing': 1, 'exposure': 20000, 'vertical_blanking': 5000, ISO_AUTO.name: 0}
    found = list(set_in_order(camera, camera.controls, values))
    assert found[:2] == [(ISO_AUTO.name, None), ('vertical_blanking', None)]
    assert [name for name, _ in found[2:]] == ['nothing', 'exposure']
    assert 'from 1 to 5000' in str(found[3][1])  # the range as it is now


class FakeHealth:
    """Takes what is shown."""

    def show(self, name: str, value: object) -> None:
        """Take a value."""


def controls_of(node: Node, start_up: dict[str, Any]) -> ControlParameters:
    """Return the parameters of a camera that are told nowhere."""
    health: Any = FakeHealth()
    return ControlParameters(node, start_up, health)


@pytest.fixture
def node(domain: int) -> Iterator[Node]:
    """Give a node; nothing spins it."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    made = Node('camera', context=context)
    yield made
    made.destroy_node()
    rclpy.shutdown(context=context)


@pytest.mark.parametrize('former, today', [
    ('exposure_auto', AUTO_EXPOSURE),
    ('white_balance_temperature_auto', replace(AUTO_GAIN, name='white_balance_automatic')),
])
def test_the_former_name_of_a_control_leads_to_that_of_today(
    former: str, today: Control, node: Node
) -> None:
    """Parameter files are older than kernels; a camera that has neither is not said to have it."""
    with_it: Any = FakeCamera(today, GAIN)
    with pytest.raises(ParameterError, match=f"no parameter '{former}'; it is '{today.name}'"):
        controls_of(node, {former: 1}).prepare(with_it)


def test_a_former_name_leads_nowhere_without_its_control(node: Node) -> None:
    """The sentence is that of any name that there is not."""
    camera: Any = FakeCamera(GAIN)
    with pytest.raises(ParameterError) as refused:
        controls_of(node, {'exposure_auto': 1}).prepare(camera)
    assert 'today' not in str(refused.value)


def test_an_inactive_mode_that_nobody_asked_for_is_no_fault(node: Node) -> None:
    """The node wants it off; as long as it has no effect there is nothing to warn of."""
    locked = replace(FRAMERATE, inactive=True)
    parameters = controls_of(node, {})
    camera: Any = FakeCamera(locked, GAIN)
    parameters.prepare(camera)
    assert parameters._rejected == ()
    # One that is active, and that the camera refuses, is told.
    camera = FakeCamera(replace(FRAMERATE, minimum=1))
    parameters.prepare(camera)
    assert len(parameters._rejected) == 1


def test_an_inactive_control_that_start_up_named_is_refused(node: Node) -> None:
    """The user asked for it."""
    parameters = controls_of(node, {'gain': 10})
    camera: Any = FakeCamera(replace(GAIN, inactive=True))
    with pytest.raises(ParameterError, match="'gain' is inactive"):
        parameters.prepare(camera)


def test_what_a_dump_tells_of_controls_that_cannot_be_set_is_no_fault(node: Node) -> None:
    """Inactive, also by a mode of the same file, read-only, and a button that nobody presses."""
    start_up = {'gain': 10, 'exposure': 600, 'button': False, 'iso_sensitivity': 1,
                'iso_sensitivity_auto': 1}
    health: Any = FakeHealth()
    parameters = ControlParameters(node, start_up, health, start_up)
    camera: Any = FakeCamera(
        replace(GAIN, inactive=True), replace(EXPOSURE, read_only=True),
        replace(GAIN, name='button', kind='button'), ISO, ISO_AUTO, iso_sensitivity_auto=0,
    )
    parameters.prepare(camera)
    assert parameters._rejected == ()
    assert {name for name, _ in camera.log} <= {ISO.name, ISO_AUTO.name}


class Trigger:
    """Stands for the guard condition, whose executor does not run here."""

    count = 0

    def trigger(self) -> None:
        """Count."""
        self.count += 1


def attached(node: Node, camera: Any) -> tuple[ControlParameters, Trigger]:
    """Give the parameters of a camera, shown, and what they would wake."""
    parameters = controls_of(node, {})
    parameters._changed = woken = Trigger()
    parameters.attach(camera)
    parameters._mirror()
    woken.count = 0
    return parameters, woken


def test_a_refused_group_leaves_everything_as_it_was(node: Node) -> None:
    """The exposure is put back before the mode that makes it inactive."""
    time = replace(EXPOSURE, name='exposure_time_absolute', number=0x009a0902, default=157)
    camera: Any = FakeCamera(AUTO_EXPOSURE, time, GAIN)
    before = dict(camera.values)
    _, woken = attached(node, camera)
    answer = node.set_parameters_atomically([
        Parameter('auto_exposure', value=1), Parameter('exposure_time_absolute', value=50),
        Parameter('gain', value=10)])
    assert answer.successful  # all of it can be set
    camera.values = dict(before)
    camera.all['gain'] = replace(GAIN, maximum=8)  # which the parameter does not know yet
    camera.log.clear()
    woken.count = 0
    answer = node.set_parameters_atomically([
        Parameter('auto_exposure', value=1), Parameter('exposure_time_absolute', value=50),
        Parameter('gain', value=10)])
    assert not answer.successful and "'gain' is 10" in answer.reason
    assert camera.values == before
    assert camera.log == [
        ('auto_exposure', 1), ('exposure_time_absolute', 50),
        ('exposure_time_absolute', 157), ('auto_exposure', 3)]
    assert woken.count == 1  # others may have moved with it


def test_what_could_not_be_read_is_read_again(node: Node) -> None:
    """A change that was told is seen only once the controls were read."""
    camera: Any = FakeCamera(GAIN)
    parameters, _ = attached(node, camera)
    camera.tells_changes = True
    camera.control_changes, camera.values['gain'] = 1, 44

    class Gone(FakeCamera):
        @property
        def controls(self) -> dict[str, Control]:
            raise CaptureError('gone')

    camera.__class__ = Gone
    parameters._refresh()
    camera.__class__ = FakeCamera
    parameters._refresh()
    assert node.get_parameter('gain').value == 44


def test_only_what_the_search_set_is_wanted(node: Node, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another program may move other controls meanwhile; those are not fought over."""
    camera: Any = FakeCamera(GAIN, BLANKING)
    parameters, woken = attached(node, camera)

    def found(camera: FakeCamera, read: object, channel: str) -> Outcome:
        camera.values.update(gain=20, vertical_blanking=77)
        return Outcome(None, 20, 0.7, True, 'found', {'gain': 20})

    monkeypatch.setattr('blob_tracker.ros.parameters.controls.adjust_exposure', found)
    parameters.adjust_exposure(camera, None, 'auto')
    assert parameters._wanted == {'gain': 20}
    assert woken.count == 1

    def broken(camera: FakeCamera, read: object, channel: str) -> Outcome:
        raise CaptureError('gone')

    monkeypatch.setattr('blob_tracker.ros.parameters.controls.adjust_exposure', broken)
    with pytest.raises(CaptureError):
        parameters.adjust_exposure(camera, None, 'auto')
    assert woken.count == 2  # what it moved is shown
