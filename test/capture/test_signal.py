"""The standard of an analogue signal; test/vm has an HDMI input."""

from __future__ import annotations

import errno
import os
from typing import Any

from blob_tracker.capture import videodev2
from blob_tracker.capture.signal import Signal
import pytest

PAL, NTSC = 0xff, 0xb000


class Grabber:
    """An analogue input that is set to a standard, and sees one, or does not tell (None)."""

    def __init__(self, standard: int, seen: int | None, crop: tuple[int, ...] = ()) -> None:
        self.standard, self.seen, self.crop = standard, seen, crop

    def __call__(self, number: int, argument: Any) -> None:
        if number == videodev2.ENUMINPUT:
            argument.std = PAL | NTSC
        elif number == videodev2.G_STD:
            argument.value = self.standard
        elif number == videodev2.S_STD:
            self.standard = argument.value
        elif number == videodev2.QUERYSTD and self.seen is not None:
            argument.value = self.seen
        elif number == videodev2.CROPCAP and self.crop:
            argument.defrect.width, argument.defrect.height = self.crop[:2]
            argument.pixelaspect = videodev2.Fract(*self.crop[2:])
        elif number != videodev2.G_INPUT:
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))

    def locked(self) -> Signal:
        signal = Signal(self)
        signal.lock('/dev/video0')
        return signal


@pytest.mark.parametrize(('standard', 'seen', 'lines'), [
    (PAL, None, 625), (NTSC, None, 525),
    (NTSC, PAL, 625), (PAL, NTSC, 525),  # the source is of the other
    (PAL, 0, 625),  # no signal yet
    (PAL | NTSC, None, 0),  # a driver that has not decided
])
def test_the_standard_is_that_of_the_signal(standard, seen, lines):
    grabber = Grabber(standard, seen)
    signal = grabber.locked()
    assert signal.lines == lines
    assert signal.frame_rate == {525: pytest.approx(29.97003), 625: 25.0, 0: 0.0}[lines]
    assert grabber.standard == (seen or standard)


def test_the_readout_is_that_of_a_field():
    assert Grabber(PAL, None).locked().readout_time == pytest.approx(288 * 64e-6)
    assert Grabber(NTSC, None).locked().readout_time == pytest.approx(240 * 63.5556e-6, rel=1e-6)
    assert Grabber(0, None).locked().readout_time is None


@pytest.mark.parametrize(('grabber', 'size', 'aspect'), [
    # ITU-R BT.601: 13.5 MHz, where square pixels take 14.75 and 12.27
    (Grabber(PAL, None), (720, 576), 54 / 59),
    (Grabber(NTSC, None), (720, 480), 11 / 10),
    (Grabber(NTSC, None), (640, 480), 11 / 10 * 640 / 720),  # the driver scales its lines
    (Grabber(PAL, None, (768, 576, 1, 1)), (768, 576), 1.0),
    (Grabber(0, None, (1920, 1080, 1, 1)), (640, 480), (1080 / 480) / (1920 / 640)),
    (Grabber(0, None), (640, 480), 1.0),
])
def test_pixels_that_are_not_square(grabber, size, aspect):
    assert grabber.locked().pixel_aspect(*size) == pytest.approx(aspect)


def test_the_numbers_of_the_standards_are_the_kernels():
    # <linux/videodev2.h>: PAL, SECAM; NTSC-M, -M-JP, -M-KR, -443, PAL-M, PAL-60
    assert videodev2.STD_525_60 & videodev2.STD_625_50 == 0
    assert videodev2.STD_525_60 == 0x1000 | 0x2000 | 0x8000 | 0x4000 | 0x100 | 0x800


def test_an_interlaced_digital_signal_has_the_rate_of_its_pictures():
    # CTA-861 format 5, 1920x1080i60: blanking is that of each field.
    def driver(number: int, argument: Any) -> None:
        if number == videodev2.ENUMINPUT:
            argument.capabilities = videodev2.IN_CAP_DV_TIMINGS
        elif number == videodev2.QUERY_DV_TIMINGS:
            bt = argument.bt
            bt.width, bt.height, bt.interlaced, bt.pixelclock = 1920, 1080, 1, 74_250_000
            bt.hfrontporch, bt.hsync, bt.hbackporch = 88, 44, 148
            bt.vfrontporch, bt.vsync, bt.vbackporch = 2, 5, 15
            bt.il_vfrontporch, bt.il_vsync, bt.il_vbackporch = 2, 5, 16

    signal = Signal(driver)
    signal.lock('/dev/video0')
    assert signal.frame_rate == pytest.approx(30.0)
    assert signal.lines == 0
