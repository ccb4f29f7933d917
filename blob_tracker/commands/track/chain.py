"""The rooms in a row as the nodes' parameters ask for them: frames to outcomes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.commands.sources import reach
from blob_tracker.commands.track.outcome import Outcome, Sentences
from blob_tracker.location import method_options
from blob_tracker.pipeline import Pipeline
from blob_tracker.ros.messages.clipping import clipping_frame
from blob_tracker.ros.parameters.rooms import (
    flash_of, line_jitter_of, pulse_of, response_of, segmenter_of,
)
from blob_tracker.ros.parameters.values import about
from blob_tracker.segmentation import FieldSegmenter
from blob_tracker.segmentation.channel import ChannelChoice
from blob_tracker.segmentation.compression import standard_quantisation
from blob_tracker.types import Frame, SensorNoise

ANY_FIELD_OF_VIEW = 50.0  # degrees, of the camera that stands in for an unknown one


class Chain:
    """
    Track a light in frames, with the numbers of the nodes.

    Parameters
    ----------
    values : mapping of str to any
        Values of the parameters of segmenter and locator.
    camera_model : CameraModel or None
        The calibration; None if there is none: places in the picture are all there is then.
    frame : Frame
        The first one, for its size.

    Attributes
    ----------
    note : str
        What of the parameters cannot be used; '' where all can.
    warnings : Sentences
        What is not as it should be.

    Raises
    ------
    ParameterError
        A value is invalid.
    CalibrationError
        The calibration is for other frames.

    """

    def __init__(
        self, values: Mapping[str, Any], camera_model: CameraModel | None, frame: Frame
    ) -> None:
        new_flash, _ = flash_of(values)
        new_segmenter = segmenter_of(values)
        pulse, self.note = pulse_of(values['pulse_url'], values['method'])
        self.angles = camera_model is not None
        width, height = reach(frame)
        if camera_model is None:  # its angles are shown to nobody
            camera_model = CameraModel.from_field_of_view(width, height, ANY_FIELD_OF_VIEW)
        else:
            _check_size(camera_model, frame)
        if pulse is not None:
            try:
                pulse.check_size(camera_model.width, camera_model.height)
            except CalibrationError as error:  # the Gaussian goes on, as in the node
                pulse, self.note = None, str(error)
        with about('method'):
            method_options(values['method'], elliptical=values['elliptical'])
        self._pipeline = Pipeline(
            camera_model,
            noise=SensorNoise(
                values['noise.gain'], values['noise.read_noise'], values['noise.black_level']
            ),
            method=values['method'],
            elliptical=values['elliptical'],
            segmenter=FieldSegmenter(lambda: new_segmenter(
                flash=new_flash(), channel=ChannelChoice(values['channel'])
            )),
            line_jitter=line_jitter_of(values['line_jitter_url']),
            pulse=None if pulse is None else pulse.learned.pulse,
            response=response_of(values['response_url']),
        )
        self._saturation = values['saturation']
        self._line_time_ns = 1e9 * values['line_time']
        quality = values['jpeg_quality']
        self._quantisation = standard_quantisation(quality) if quality else None
        self.warnings = Sentences()

    @property
    def finding(self) -> str:
        """Return what the flash mode found out about the light."""
        return self._pipeline.segmenter.finding

    def outcomes(self, name: str, frame: Frame) -> Iterator[Outcome]:
        """Yield the lights that the next frame shows, or the reason why there is none."""
        there = False
        for light, location, bearing in self._pipeline.placed(self._prepared(frame)):
            there = True
            self.warnings.add(self._pipeline.warning)
            yield Outcome(name, frame, light, location, bearing if self.angles else None)
        segmenter = self._pipeline.segmenter
        for warning in segmenter.warnings:
            self.warnings.add(warning)
        if not there:
            yield Outcome(name, frame, reason=segmenter.reason)

    def _prepared(self, frame: Frame) -> Frame:
        """Return a frame with what the parameters tell of it, as the segmenter's node does."""
        if self._saturation:
            frame = clipping_frame(frame, self._saturation)
        if self._line_time_ns:
            frame = replace(frame, line_time_ns=self._line_time_ns)
        if frame.quantisation is None and self._quantisation is not None:
            frame = replace(frame, quantisation=self._quantisation)
        return frame


def _check_size(camera_model: CameraModel, frame: Frame) -> None:
    """Refuse the calibration of another size; of a crop nobody knows where the sensor ends."""
    size = camera_model.width, camera_model.height
    if (frame.x0, frame.y0, frame.binning) == (0, 0, (1, 1)) and reach(frame) != size:
        width, height = reach(frame)
        raise CalibrationError(
            f'the calibration is for {size[0]} x {size[1]} px and the frames are of {width} x '
            f'{height} px; calibrate at {width} x {height} px'
        )
