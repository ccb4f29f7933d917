"""The images of a topic, while the nodes run."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker.commands.sources.source import frame_of, Source, SourceError, SourceFrame


def open_topic(topic: str, *, interpolate: bool, woven: bool) -> Source:
    """Listen to a topic; its images are grey, see `blob_tracker.colour.grey_pixels`."""
    return Source(_frames(topic, interpolate, woven), stamps='the messages')


def _frames(topic: str, interpolate: bool, woven: bool) -> Iterator[SourceFrame]:
    try:
        from blob_tracker.ros.endpoints.live_images import live_images, NoImagesError
    except ImportError:
        raise SourceError(
            f"there is no folder '{topic}', and no ROS to listen to a topic of that name"
        ) from None
    try:
        for seconds, pixels in live_images(topic, interpolate=interpolate, woven=woven):
            yield frame_of(pixels, f'{seconds:.3f} s', round(1e9 * seconds))
    except NoImagesError as error:
        raise SourceError(str(error)) from None
