"""The images of a topic, while the nodes run."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker.commands.sources.source import Source, SourceError, SourceFrame


def open_topic(topic: str, *, woven: bool) -> Source:
    """Listen to a topic."""
    return Source(_frames(topic, woven), stamps='the messages')


def _frames(topic: str, woven: bool) -> Iterator[SourceFrame]:
    try:
        from blob_tracker.ros.endpoints.live_images import live_images, NoImagesError
    except ImportError:
        raise SourceError(
            f"there is no folder '{topic}', and no ROS to listen to a topic of that name"
        ) from None
    try:
        first_ns: int | None = None
        for frame, sensor in live_images(topic, woven=woven):
            first_ns = frame.stamp_ns if first_ns is None else first_ns
            yield SourceFrame(
                f'{(frame.stamp_ns - first_ns) / 1e9:.3f} s', frame, True, sensor
            )
    except NoImagesError as error:
        raise SourceError(str(error)) from None
