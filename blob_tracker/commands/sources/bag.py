"""The images of a bag."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from blob_tracker.capture.fields import Weaver
from blob_tracker.commands.sources.source import Source, SourceError, SourceFrame
from blob_tracker.ros.bags import opened, RecordingError
from blob_tracker.ros.endpoints.recording import (
    recorded_count, recorded_frames, recorded_info,
)
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.camera_info import KnownCamera
from blob_tracker.ros.messages.image import binning_of, placed, sensor_of
from blob_tracker.types import field_of


def open_bag(bag: Path, topic: str | None, *, calibrated: bool, woven: bool) -> Source:
    """
    Open a bag.

    Parameters
    ----------
    bag : Path
        The bag.
    topic : str or None
        Of the images, see `recorded_frames`.
    calibrated : bool
        Whether its camera_info is wanted: frames that have none are then left out, as the nodes
        leave them out, where the bag has any at all.
    woven : bool
        Whether fields, of which the camera_info tells, are put together to pictures.

    Raises
    ------
    SourceError
        It cannot be read, or has no such images.

    """
    camera = KnownCamera()
    try:
        with opened(bag) as recording:  # once: without an index all of it is looked at
            count = recorded_count(recording, topic)
            info = recorded_info(recording, topic)
    except RecordingError as error:
        raise SourceError(str(error)) from None
    if not calibrated:
        frames = _frames(bag, topic, info, woven and _is_field(info), None)
        return Source(_pictures(frames) if woven else frames, count, 'the bag')
    model, uncalibrated = None, 'the bag has no camera_info beside its images'
    if info is not None:
        try:
            model, uncalibrated = camera.model(info), ''
        except MessageError as error:
            uncalibrated = str(error)
    check = None if model is None else (lambda info: camera.model(info) is model)
    return Source(
        _frames(bag, topic, info, info is not None, check), count, 'the bag', model, uncalibrated
    )


def _is_field(info: Any | None) -> bool:
    """Tell whether the images of a camera_info are fields."""
    if info is None:
        return False
    return field_of(int(info.roi.y_offset), binning_of(info)) is not None


def _pictures(fields: Iterator[SourceFrame]) -> Iterator[SourceFrame]:
    """Yield the pictures of fields, with name and stamp of the later field."""
    weaver = Weaver()
    for each in fields:
        picture = each.frame if each.sensor is None else weaver.whole(each.frame, each.sensor[1])
        if picture is not None:
            yield each._replace(frame=picture)


def _frames(
    bag: Path, topic: str | None, first: Any | None, paired: bool,
    same: Callable[[object], bool] | None,
) -> Iterator[SourceFrame]:
    """Yield the frames of a bag; those without a camera_info of their own go by the first."""
    first_ns: int | None = None
    try:
        for frame, own in recorded_frames(bag, topic, paired=paired):
            info, sensor = own or first, None
            if info is not None:
                with suppress(MessageError):  # one of another size says nothing of these
                    frame, sensor = placed(frame, info), sensor_of(info)
            first_ns = frame.stamp_ns if first_ns is None else first_ns
            name = f'{(frame.stamp_ns - first_ns) / 1e9:.3f} s'
            if same is not None and not same(info):
                raise SourceError(
                    f'{bag}: the calibration in camera_info is another one from {name} on; part '
                    'the bag there'
                )
            yield SourceFrame(name, frame, True, sensor)
        if first_ns is None and paired:
            raise SourceError(
                f'{bag}: no image has a camera_info of its stamp or near it; give the '
                'calibration with --camera-info'
            )
    except (RecordingError, MessageError) as error:
        raise SourceError(str(error)) from None
