"""From the driver's stamp to the middle of the exposure, with exposures that change."""


from blob_tracker.capture import Control, stamps, videodev2
from blob_tracker.capture.stamps import (
    Exposure, ExposureControls, MidExposure, of_first_line, place, source_of,
)
import numpy as np
import pytest

MS = 1_000_000
LATER = 10**18
SOE = videodev2.BUF_FLAG_TSTAMP_SRC_SOE


@pytest.mark.parametrize(('source', 'readout_ns', 'middle'), [
    ('exposure start', None, 104 * MS),
    ('exposure start', 5 * MS, 104 * MS),
    ('transfer start', None, 96 * MS),
    ('frame start', 5 * MS, 96 * MS),
    ('transfer end', None, 96 * MS),
    ('transfer end', 5 * MS, 91 * MS),
])
def test_the_middle_of_an_exposure_of_8_ms(source, readout_ns, middle):
    assert MidExposure(source, Exposure(8 * MS, readout_ns)).middle(100 * MS, LATER) == middle


@pytest.mark.parametrize('source', ['exposure start', 'transfer start', 'transfer end'])
def test_without_exposure_the_stamp_is_the_drivers(source):
    assert MidExposure(source, Exposure()).middle(100 * MS, LATER) == 100 * MS


@pytest.mark.parametrize(('source', 'readout_ns', 'words'), [
    ('exposure start', None, 'middle of the exposure'),
    ('transfer end', 5 * MS, 'middle of the exposure'),
    ('frame start', 5 * MS, 'middle of the exposure'),
    ('transfer end', None, 'middle of the exposure, later by the time of the readout, which is '
                           'unknown and taken as 0'),
    ('camera clock', None, 'middle of the exposure, if the camera sends its own time, else near '
                           'the start of the transfer'),
    ('transfer start', None, 'middle of the exposure, as far as the camera sends it at once'),
])
def test_place_in_words(source, readout_ns, words):
    assert place(source, Exposure(8 * MS, readout_ns)) == words
    assert place(source, Exposure(None, readout_ns)).split(',')[0] == (
        'start of the exposure' if source in ('exposure start', 'camera clock') else
        'end of the exposure')


@pytest.mark.parametrize('source', ['exposure start', 'transfer start', 'transfer end'])
def test_a_change_holds_from_the_first_exposure_that_begins_after_it(source):
    interval, readout = 20 * MS, 6 * MS
    exposures = {0: 16 * MS, 5: 2 * MS, 9: 10 * MS, 10: 4 * MS}  # from frame on
    middles = MidExposure(source, Exposure(16 * MS, readout))
    time_ns = 0
    for number in range(15):
        begin = 1000 * MS + number * interval
        if number in exposures and number:
            time_ns = exposures[number]
            # While the frame before is still exposed, or being sent.
            middles.changed(begin - 1 * MS, Exposure(time_ns, readout))
        time_ns = exposures.get(number, time_ns)
        stamp = {'exposure start': begin, 'transfer start': begin + time_ns,
                 'transfer end': begin + time_ns + readout}[source]
        assert middles.middle(stamp, LATER) == begin + time_ns // 2, number
        assert middles.time_ns == time_ns


@pytest.mark.parametrize(('transfer', 'middle'), [(0.3, True), (0.99, False)])
def test_a_stamp_a_whole_interval_before_its_frame_is_not_the_middle(transfer, middle):
    interval = 33 * MS
    stamps = MidExposure('transfer start', Exposure(8 * MS))
    for frame in range(1, 40):
        late = 30 * MS if frame % 5 == 0 else 0  # a busy reader
        stamps.middle(frame * interval, frame * interval + round(transfer * interval) + late)
    assert stamps.place.startswith('middle of the exposure') is middle
    assert ('without a pause' in stamps.place) is not middle


def test_a_frame_begun_before_the_change_keeps_the_old_exposure():
    middles = MidExposure('exposure start', Exposure(8 * MS))
    middles.changed(110 * MS, Exposure(2 * MS))
    assert middles.middle(100 * MS, LATER) == 104 * MS
    assert middles.middle(120 * MS, LATER) == 121 * MS
    assert len(middles._changes) == 1  # what is over is forgotten


@pytest.mark.parametrize('source', ['exposure start', 'transfer start', 'transfer end'])
def test_order_is_kept_whatever_comes(source):
    random = np.random.default_rng(4)
    middles = MidExposure(source, Exposure(10 * MS))
    read_ns = 1000 * MS
    last = 0
    for _ in range(2000):
        read_ns += int(random.integers(1, 20 * MS))
        if random.random() < 0.2:
            middles.changed(read_ns, Exposure(int(random.integers(0, 40 * MS))))
        # Late, early, and now and then from the future.
        stamp = read_ns + int(random.normal(-5 * MS, 20 * MS))
        middle = middles.middle(stamp, read_ns)
        assert last < middle <= read_ns
        last = middle


@pytest.mark.parametrize(('flags', 'driver', 'hardware', 'source'), [
    (SOE, 'vivid', None, 'exposure start'),
    (0, 'vivid', None, 'transfer end'),
    (0, 'unicam', None, 'frame start'),
    (0, 'rp1-cfe', None, 'frame start'),
    (SOE, 'uvcvideo', None, 'transfer start'),
    (SOE, 'uvcvideo', '0\n', 'transfer start'),
    (SOE, 'uvcvideo', '1\n', 'camera clock'),
])
def test_what_a_driver_stamps(flags, driver, hardware, source, tmp_path, monkeypatch):
    option = tmp_path / 'hwtimestamps'
    if hardware is not None:
        option.write_text(hardware)
    monkeypatch.setattr(stamps, 'HARDWARE_STAMPS', option)
    assert source_of(flags, driver) == source


class Driver:
    """Values of controls by number, as the ioctls give them."""

    def __init__(self, values):
        self.values = values

    def __call__(self, number, argument):
        assert number == videodev2.G_EXT_CTRLS
        one = argument.controls[0]
        value = self.values[one.id]
        if value > 0x7fffffff:
            one.value.value64 = value
        else:
            one.value.value = value

    @property
    def controls(self):
        return {str(number): Control(
            number, str(number), '', 'integer64' if number == videodev2.CID_PIXEL_RATE
            else 'integer', 0, 2**40, 1, 0, {}, False, self.inactive, False)
            for number in self.values}

    inactive = False

    def exposure(self, otherwise=Exposure()):
        return ExposureControls(self, self.controls, 1280, 800, otherwise).read()


def test_exposure_in_units_of_100_us():
    driver = Driver({videodev2.CID_EXPOSURE_ABSOLUTE: 157, videodev2.CID_EXPOSURE_AUTO: 1})
    assert driver.exposure() == Exposure(15_700_000, None)
    assert driver.exposure(Exposure(1, 2)) == Exposure(15_700_000, 2)


@pytest.mark.parametrize('automatic', [0, 3])
def test_an_automatic_exposure_is_unknown(automatic):
    driver = Driver({videodev2.CID_EXPOSURE_ABSOLUTE: 157,
                     videodev2.CID_EXPOSURE_AUTO: automatic})
    assert driver.exposure() == Exposure(None, None)
    assert driver.exposure(Exposure(4 * MS)) == Exposure(4 * MS, None)


def test_an_exposure_that_an_unknown_mode_governs_is_unknown():
    driver = Driver({videodev2.CID_EXPOSURE_ABSOLUTE: 157})
    assert driver.exposure().time_ns == 15_700_000
    driver.inactive = True
    assert driver.exposure().time_ns is None


def test_exposure_in_lines_gives_the_readout_too():
    driver = Driver({videodev2.CID_EXPOSURE: 500, videodev2.CID_HBLANK: 176,
                     videodev2.CID_PIXEL_RATE: 160_000_000})
    line_ns = (1280 + 176) / 0.16  # 9.1 us
    assert driver.exposure() == Exposure(
        round(500 * line_ns), round(800 * line_ns), line_ns
    )
    assert ExposureControls(driver, driver.controls, 1280, 800, Exposure()).unit_ns() == line_ns


def test_a_pixel_rate_above_32_bits():
    driver = Driver({videodev2.CID_EXPOSURE: 500, videodev2.CID_HBLANK: 0,
                     videodev2.CID_PIXEL_RATE: 12_800_000_000})
    assert driver.exposure().time_ns == 50_000


def test_lines_of_unknown_length_are_unknown():
    assert Driver({videodev2.CID_EXPOSURE: 500}).exposure() == Exposure()


@pytest.mark.parametrize(('line_time_ns', 'binning', 'later_ns'), [
    (0.0, 1, 0),
    (20_000.0, 1, 0),
    (20_000.0, 2, 5_000),  # two lines of 10 us: the middle of both
    (-20_000.0, 1, 9 * 20_000),  # read from the bottom: the first line comes last
])
def test_when_the_first_line_is_exposed(line_time_ns, binning, later_ns):
    assert of_first_line(line_time_ns, 10, binning) == later_ns


@pytest.mark.parametrize(('told', 'middle'), [(True, 104 * MS), (False, 96 * MS)])
def test_a_camera_that_sends_its_time_is_stamped_by_it(told, middle):
    stamps = MidExposure('camera clock', Exposure(8 * MS))
    stamps.camera_clock(None)
    assert 'if the camera sends its own time' in stamps.place
    stamps.camera_clock(told)
    assert 'if the camera' not in stamps.place
    assert stamps.middle(100 * MS, LATER) == middle
