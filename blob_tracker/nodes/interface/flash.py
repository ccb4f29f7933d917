"""How the light flashes: parameters of the segmenter, and of the simulator that shows it."""

from blob_tracker.flash_text import DUTIES, FLASH_MODE_NAMES, MOST_UNNAMED
from blob_tracker.ros.interface import Parameter

FLASH = (
    Parameter(
        'flash.mode',
        'alternate',
        'How the light flashes. alternate: in step with the camera, on in every other frame. '
        'periodic: free-running at flash.frequency, or several at flash.frequencies. coded: '
        'lights that blink flash.codes. lock_in: a faint light at flash.frequency that stands '
        'still. steady: always on. auto: unknown; alternate is tried first, then whatever blinks '
        'is watched for 3 s and the brightest light followed; the diagnostics say what to set.',
        choices=FLASH_MODE_NAMES,
    ),
    Parameter(
        'flash.lights',
        1,
        'Greatest number of lights at once, in the modes steady and alternate: a body of lights '
        'that look alike. From 2 on they have topics of their own, target/light_1/..., and the '
        'node constellation tells which is which (docs/constellation.md).',
        least=1,
        most=MOST_UNNAMED,
    ),
    Parameter(
        'flash.frequency',
        15.0,
        'Frequency of a light without a name; from 0.02 (lock_in: 0.1) to 0.45 of the frame rate.',
        least=0.01,
        most=500.0,
        unit='Hz',
    ),
    Parameter(
        'flash.duty',
        0.5,
        'Part of its period for which a periodic light is on.',
        least=DUTIES[0],
        most=DUTIES[1],
    ),
    Parameter(
        'flash.frequencies',
        '',
        'Frequencies of periodic lights by their names, Hz: left:6.0,right:10.0. They may stand '
        'beside flash.codes, and must differ by 2 % or more.',
    ),
    Parameter(
        'flash.codes',
        '',
        'Bits of the coded lights: port:1101000,starboard:1110100. Each has its own topics, '
        'target/port/... No code may be a rotation of another.',
    ),
    Parameter(
        'flash.frames_per_bit',
        1,
        'Frames for which a coded light holds each bit, if flash.bits_per_second is 0.',
        least=1,
        most=64,
    ),
    Parameter(
        'flash.bits_per_second',
        0.0,
        'Bits a second that coded lights send by their own clock, which may be off by 1 %. 0: in '
        'step with the frames.',
        least=0.0,
        most=1000.0,
    ),
    Parameter(
        'flash.exposure',
        0.0,
        'How long a frame is exposed: it fixes when a light that was switched meanwhile was seen. '
        '0: what the camera in this process says, or half the frame interval.',
        least=0.0,
        most=1.0,
        unit='s',
    ),
)
