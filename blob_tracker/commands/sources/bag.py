"""The images of a bag."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from blob_tracker.capture.fields import Weaver
from blob_tracker.commands.sources.source import Source, SourceError, SourceFrame
from blob_tracker.ros.bags import opened, RecordingError
from blob_tracker.ros.endpoints.recording import (
    recorded_count, recorded_frames, recorded_info,
)
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.camera_info import KnownCamera
from blob_tracker.ros.messages.image import field_and_height
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
            info = recorded_info(recording, topic) if calibrated or woven else None
    except RecordingError as error:
        raise SourceError(str(error)) from None
    if woven:
        field, height = field_and_height(info) if info is not None else (None, 0)
        frames = _frames(bag, topic, field is not None, None)
        return Source(frames if field is None else _pictures(frames, height), count, 'the bag')
    model, uncalibrated = None, 'the bag has no camera_info beside its images'
    if info is not None:
        try:
            model, uncalibrated = camera.model(info), ''
        except MessageError as error:
            uncalibrated = str(error)
    check = None if model is None else (lambda info: camera.model(info) is model)
    return Source(
        _frames(bag, topic, info is not None, check), count, 'the bag', model, uncalibrated
    )


def _pictures(fields: Iterator[SourceFrame], height: int) -> Iterator[SourceFrame]:
    """Yield the pictures of fields, of so many lines, with name and stamp of the later field."""
    weaver = Weaver()
    for name, frame, stamped in fields:
        picture = weaver.add(frame.image, field_of(frame.y0, frame.binning), height)
        if picture is not None:
            whole = replace(frame, image=picture, y0=0, binning=(1, 1))
            yield SourceFrame(name, whole, stamped)


def _frames(
    bag: Path, topic: str | None, paired: bool, same: Callable[[object], bool] | None
) -> Iterator[SourceFrame]:
    first_ns: int | None = None
    try:
        for frame, info in recorded_frames(bag, topic, paired=paired):
            first_ns = frame.stamp_ns if first_ns is None else first_ns
            name = f'{(frame.stamp_ns - first_ns) / 1e9:.3f} s'
            if same is not None and not same(info):
                raise SourceError(
                    f'{bag}: the calibration in camera_info is another one from {name} on; part '
                    'the bag there'
                )
            yield SourceFrame(name, frame, True)
        if first_ns is None and paired:
            raise SourceError(
                f'{bag}: no image has a camera_info of its stamp; give the calibration with '
                '--camera-info'
            )
    except (RecordingError, MessageError) as error:
        raise SourceError(str(error)) from None
