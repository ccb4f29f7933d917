"""What the values of the nodes' parameters ask of the rooms, with and without a node."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Any

from blob_tracker.calibration.pulse_file import PulseFile
from blob_tracker.camera import CameraModel
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.camera.response import Response
from blob_tracker.flash_text import codes_from_text, frequencies_from_text, numbered_lights
from blob_tracker.location import method_options
from blob_tracker.ros.endpoints.names import check_light
from blob_tracker.ros.parameters.mask import read_mask
from blob_tracker.ros.parameters.url import to_path
from blob_tracker.ros.parameters.values import about
from blob_tracker.segmentation import flash_by_name, Segmenter, threshold_by_name
from blob_tracker.segmentation.flash import Flash

FLASH = ('max_pair_interval', 'registration', 'gate')  # that make another flash mode, too
LONGEST = 400  # characters of a reason


def flash_values(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of a segmenter's parameters that make its flash mode."""
    return {
        name: value for name, value in values.items()
        if name.startswith('flash.') or name in FLASH
    }


def flash_of(values: Mapping[str, Any]) -> tuple[Callable[[], Flash], Collection[str]]:
    """
    Return what makes the flash mode, and the names of the lights; '' of one without a name.

    Raises
    ------
    ParameterError
        If one of the values is invalid.

    """
    with about('flash'):
        codes = codes_from_text(values['flash.codes'])
        frequencies = frequencies_from_text(values['flash.frequencies'])
        for name in (*codes, *frequencies):
            check_light(name)
        options = {
            name.removeprefix('flash.'): value for name, value in flash_values(values).items()
        }
        options['gate_px'] = options.pop('gate')
        new_flash = partial(
            flash_by_name, **options | {'codes': codes, 'frequencies': frequencies}
        )
        new_flash()  # or it says what cannot be
    named = {'coded': (*codes, *frequencies), 'periodic': tuple(frequencies)}
    return new_flash, named.get(values['flash.mode']) or numbered_lights(values['flash.lights'])


def segmenter_of(values: Mapping[str, Any]) -> Callable[..., Segmenter]:
    """
    Return what makes a segmenter, of a flash mode and a choice of the channel.

    Raises
    ------
    ParameterError
        If one of the values is invalid.

    """
    with about('mask_url'):
        mask = read_mask(values['mask_url'])
    return partial(
        Segmenter,
        threshold=threshold_by_name(
            values['threshold.method'],
            sigmas=values['threshold.sigmas'],
            extension=values['threshold.extension'],
        ),
        min_snr=values['min_snr'],
        max_blob=values['max_blob'],
        looks=values['looks'],
        mask=mask,
    )


def camera_of(url: str, warn: Callable[[str], Any]) -> CameraModel | None:
    """Return the calibration of the parameter `camera_info_url`; None if it is empty."""
    if not url:
        return None
    with about('camera_info_url'):
        return CameraModel.from_file(to_path(url), warn=warn)


def line_jitter_of(url: str) -> LineJitter | None:
    """Return the line jitter of the parameter `line_jitter_url`; None if it is empty."""
    if not url:
        return None
    with about('line_jitter_url'):
        return LineJitter.from_yaml(to_path(url))


def response_of(url: str) -> Response | None:
    """Return the response of the parameter `response_url`; None of a linear camera, for ''."""
    if not url:
        return None
    with about('response_url'):
        return Response.from_yaml(to_path(url))


def pulse_of(url: str, method: str) -> tuple[PulseFile | None, str]:
    """Return the pulse of the parameter `pulse_url`, or None and why it is not used."""
    if not url:
        return None, ''
    try:
        file = PulseFile.from_yaml(to_path(url))
        method_options(method, pulse=file.learned.pulse)
    except ValueError as error:  # CalibrationError and ParameterError are two of them
        reason = str(error)
        # It is said with every bearing: a name of any length must not be.
        return None, reason if len(reason) < LONGEST else f'{reason[:LONGEST // 2]} ...'
    return file, ''
