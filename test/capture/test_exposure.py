"""The search for exposure and gain, on simulated sensors of many kinds."""

from dataclasses import replace
from types import MappingProxyType

from blob_tracker.capture import CaptureError, Control, ControlError, videodev2
from blob_tracker.capture.exposure import adjust_exposure, lit_peak, peak_of_channel
from blob_tracker.capture.exposure_search import Scale, search, TARGET, TOLERANCE
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.types import Frame
import numpy as np
import pytest

SHAPE = (16, 20)
INTERVAL_NS = 16_000_000


def control(number, name, scale):
    return Control(number, name, name, 'integer', scale.minimum, scale.maximum, scale.step,
                   scale.minimum, MappingProxyType({}), False, False, False)


class Sensor:
    """
    A flashing light on a sensor: shot noise, read noise, black level, quantisation, clipping.

    `brightness` is the peak at the longest exposure that is allowed and the least gain, of full
    scale. A change of a control comes into force `latency` frames later.
    """

    def __init__(self, random, clock, brightness):
        self.random = random
        self.clock = clock
        self.brightness = brightness
        self.saturation = int(random.choice([255, 1023, 4095, 65535]))
        self.black = random.uniform(0.0, 0.06)
        self.electrons = random.uniform(2000, 20000)  # at full scale and the least gain
        self.read_noise = random.uniform(0.0005, 0.003)  # of full scale
        self.decibels = random.choice([True, False])
        self.latency = int(random.integers(0, 3))
        self.phase = int(random.integers(0, 2))
        self.frame_rate = 60.0
        step = int(random.choice([1, 1, 2, 5]))
        self.exposure = Scale(step, int(random.choice([2500, 10000])), step)
        # 0 to 24 dB in steps of 0.1 or 0.3 dB, or a factor of 1 to 16 in sixteenths.
        self.gain = (Scale(0, 240, int(random.choice([1, 3]))) if self.decibels
                     else Scale(16, 256, 1))
        self.exposure_unit = 0.5 / self.frame_rate / random.integers(200, 1000)
        self.longest = self.exposure.value(
            self.exposure.index(0.5 / self.frame_rate / self.exposure_unit))
        self.values = {
            'exposure_auto': 3,
            'exposure_absolute': self.exposure.value(
                int(random.integers(0, self.exposure.top + 1))),
            'gain': self.gain.value(int(random.integers(0, self.gain.top + 1)))}
        self.in_force = [dict(self.values)] * (self.latency + 1)
        self.changes = 0
        y, x = random.uniform(6, 9, 2)
        self.pulse = pixel_integrated_gaussian(SHAPE, x, y, random.uniform(1.0, 2.0))
        self.pulse /= self.pulse.max()
        self.count = 0

    @property
    def controls(self):
        return {made.name: made for made in (
            control(videodev2.CID_EXPOSURE_AUTO, 'exposure_auto', Scale(0, 3)),
            control(videodev2.CID_EXPOSURE_ABSOLUTE, 'exposure_absolute', self.exposure),
            control(videodev2.CID_GAIN, 'gain', self.gain))}

    def get_control(self, name):
        return self.values[name]

    def set_control(self, name, value):
        scale = {'exposure_absolute': self.exposure, 'gain': self.gain}.get(name, Scale(0, 3))
        assert scale.minimum <= value <= scale.maximum
        assert (value - scale.minimum) % scale.step == 0
        if name == 'exposure_absolute':
            assert value <= max(self.longest, scale.minimum)
        if value != self.values[name]:
            self.changes += 1
        self.values[name] = value

    def amplification(self, gain):
        return 10 ** (gain / 200) if self.decibels else gain / 16

    def peak(self, values):
        """Return the lit peak without noise, of full scale."""
        light = self.brightness * values['exposure_absolute'] / self.longest
        return min(1.0, self.black + light * self.amplification(values['gain']))

    def read(self):
        self.in_force = [*self.in_force[1:], dict(self.values)]
        values = self.in_force[0]
        self.count += 1
        self.clock.now += INTERVAL_NS
        light = self.brightness * values['exposure_absolute'] / self.longest
        lit = (self.count + self.phase) % 2
        mean = self.electrons * light * (0.05 + 0.95 * lit * self.pulse)
        signal = self.random.poisson(mean) / self.electrons * self.amplification(values['gain'])
        signal += self.black + self.random.normal(0.0, self.read_noise, SHAPE)
        image = np.clip(np.round(signal * self.saturation), 0, self.saturation)
        # Taken half an interval before it is read.
        return Frame(image.astype(np.uint8 if self.saturation == 255 else np.uint16),
                     self.clock.now - INTERVAL_NS // 2, self.saturation)


class Clock:
    now = 1_700_000_000_000_000_000


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr('time.time_ns', lambda: clock.now)
    return clock


@pytest.mark.parametrize('seed', range(100))
def test_the_lit_peak_comes_to_the_target(seed, clock):
    random = np.random.default_rng(seed)
    # From four times too bright at the longest exposure to what 18 dB of gain bring up.
    sensor = Sensor(random, clock, np.exp(random.uniform(np.log(0.1), np.log(4.0))))
    outcome = adjust_exposure(sensor, sensor.read)
    assert outcome.found, outcome.words
    # What was measured is the greatest of six lit frames, which lies above the mean by their
    # noise: 1.3 standard deviations of one pixel and more, as some pixels share the peak.
    amplification = sensor.amplification(sensor.values['gain'])
    noise = np.hypot(np.sqrt(TARGET * amplification / sensor.electrons), sensor.read_noise)
    true_peak = sensor.peak(sensor.values)
    assert true_peak <= TARGET + TOLERANCE + noise
    assert true_peak >= TARGET - TOLERANCE - 4 * noise
    # Gain only where the exposure is as long as it may be, but for less than one step of it.
    assert (sensor.values['gain'] == sensor.gain.minimum
            or sensor.values['exposure_absolute'] == sensor.longest
            or sensor.amplification(sensor.values['gain']) < 1.0 + 2.0 * sensor.exposure.step
            / sensor.values['exposure_absolute'])
    assert sensor.values['exposure_auto'] == 1
    assert sensor.changes < 40  # a bracket of 10000 x 240 steps takes 22 halvings alone


@pytest.mark.parametrize('seed', range(5))
def test_too_little_light_is_told(seed, clock):
    sensor = Sensor(np.random.default_rng(seed), clock, 0.005)
    outcome = adjust_exposure(sensor, sensor.read)
    assert not outcome.found
    assert outcome.words.startswith('too dark: the lit peak is at ')
    assert sensor.values['exposure_absolute'] == sensor.longest
    assert sensor.values['gain'] == sensor.gain.value(sensor.gain.top)


@pytest.mark.parametrize('seed', range(5))
def test_too_much_light_is_told(seed, clock):
    sensor = Sensor(np.random.default_rng(seed), clock, 1e5)
    outcome = adjust_exposure(sensor, sensor.read)
    assert not outcome.found
    assert outcome.words.startswith('too bright: the lit peak is at 100 % of full scale with ')
    assert sensor.values['exposure_absolute'] == sensor.exposure.minimum
    assert sensor.values['gain'] == sensor.gain.minimum


def followed(course, peak_of):
    """Run a search against a response; return its outcome and the settings that it tried."""
    tried = []
    try:
        tried.append(next(course))
        while True:
            tried.append(course.send(peak_of(*tried[-1])))
    except StopIteration as end:
        return end.value, tried


def test_a_scale_of_steps_too_coarse_is_made_up_for_by_gain():
    # 1, 2, 3 ... units of 0.4: nothing between 0.4 and 0.8.
    outcome, _ = followed(search(Scale(1, 100), Scale(0, 100), start=50),
                          lambda exposure, gain: min(1.0, 0.4 * exposure * (1 + gain / 50)))
    assert outcome.found
    assert outcome.exposure == 1
    assert 0.65 <= 0.4 * (1 + outcome.gain / 50) <= 0.75


def test_without_gain_the_nearest_step_is_told():
    outcome, _ = followed(search(Scale(1, 100), None, start=50),
                          lambda exposure, gain: min(1.0, 0.4 * exposure))
    assert (outcome.found, outcome.exposure, outcome.gain) == (False, 1, None)
    assert outcome.words == ('the lit peak is at 40 % of full scale: the nearest to 70 % that the '
                             'steps of the controls allow')


def test_gain_alone():
    outcome, _ = followed(search(None, Scale(-30, 90, 3)),
                          lambda exposure, gain: min(1.0, 0.1 * 10 ** (gain / 60)))
    assert outcome.found
    assert outcome.exposure is None


@pytest.mark.parametrize('response', [
    lambda exposure, gain: 0.0,
    lambda exposure, gain: 1.0,
    lambda exposure, gain: 0.2 if exposure % 2 else 0.9,  # nonsense ends too
    lambda exposure, gain: 0.6 + 1e-6 * exposure,
])
def test_every_response_ends(response):
    outcome, tried = followed(search(Scale(1, 10000), Scale(0, 1000), start=300), response)
    assert not outcome.found
    assert len(tried) < 200


def test_a_hot_pixel_is_not_the_peak():
    image = np.full(SHAPE, 20, np.uint8)
    image[3, 4] = 255
    assert lit_peak(image) == 50.0
    image[9:12, 9:12] = [[60, 90, 60], [90, 150, 90], [60, 90, 60]]
    assert lit_peak(image) == 150.0


def test_a_camera_without_either_control_is_told(clock):
    sensor = Sensor(np.random.default_rng(0), clock, 1.0)
    automatic = control(videodev2.CID_EXPOSURE_AUTO, 'exposure_auto', Scale(0, 3))

    class Bare(Sensor):
        controls = {'exposure_auto': automatic}

    sensor.__class__ = Bare
    with pytest.raises(ControlError, match='no control for exposure or gain; its controls are '
                                           'exposure_auto'):
        adjust_exposure(sensor, sensor.read)


def test_what_it_set_is_told(clock):
    sensor = Sensor(np.random.default_rng(0), clock, 0.5)
    assert dict(adjust_exposure(sensor, sensor.read).controls) == sensor.values


@pytest.mark.parametrize('error', [CaptureError('unplugged'), ControlError('locked')])
@pytest.mark.parametrize('reads', [0, 3, 40])
def test_a_search_that_breaks_off_puts_everything_back(clock, error, reads):
    sensor = Sensor(np.random.default_rng(0), clock, 0.5)
    sensor.values['exposure_absolute'] = sensor.exposure.value(3)  # the fake bounds what is set
    before = dict(sensor.values)

    def read():
        if sensor.count == reads:
            assert sensor.values != before
            raise error
        return sensor.read()

    with pytest.raises(CaptureError) as caught:
        adjust_exposure(sensor, read)
    assert caught.value is error
    assert sensor.values == before


def test_a_mode_that_is_inactive_is_left_alone(clock):
    class Inactive(Sensor):
        @property
        def controls(self):
            found = super().controls
            return found | {'exposure_auto': replace(found['exposure_auto'], inactive=True)}

        def set_control(self, name, value):
            assert name != 'exposure_auto'
            super().set_control(name, value)

    sensor = Inactive(np.random.default_rng(0), clock, 0.5)
    assert 'exposure_auto' not in adjust_exposure(sensor, sensor.read).controls
    assert sensor.values['exposure_auto'] == 3


@pytest.mark.parametrize('layout', ['rggb', 'bgr'])
@pytest.mark.parametrize('channel', ['auto', 'red'])
def test_a_red_light_is_not_clipped_in_red(layout, channel, clock):
    # Green and blue see a twelfth of it: by their light, or luma, red would be far beyond full.
    class Red(Sensor):
        saturation = 255

        def read(self):
            frame = super().read()
            weak = (frame.image // 12).astype(frame.image.dtype)
            if layout == 'bgr':
                image = np.dstack([weak, weak, frame.image])
            else:
                image = weak.repeat(2, axis=0).repeat(2, axis=1)
                image[::2, ::2] = frame.image
            return replace(frame, image=image, layout=layout)

    sensor = Red(np.random.default_rng(1), clock, 2.0)
    outcome = adjust_exposure(sensor, sensor.read, channel=channel)
    assert outcome.found, outcome.words
    assert sensor.peak(sensor.values) == pytest.approx(TARGET, abs=2 * TOLERANCE)
    frame = sensor.read()
    assert peak_of_channel(frame, 'green') < 0.1
