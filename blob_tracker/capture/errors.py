"""What goes wrong between the light and the frame."""


class CaptureError(RuntimeError):
    """
    No frame can be had; the message says what is wrong and what would be right.

    Examples
    --------
    >>> from blob_tracker.capture import V4l2Camera
    >>> V4l2Camera('/dev/nowhere')  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.capture.errors.CaptureError: /dev/nowhere: there is no such device; ...

    """


class NoFrameError(CaptureError):
    """
    No frame came in time; the camera may be read again.

    Examples
    --------
    A camera that waits for a trigger:

    >>> from blob_tracker.capture import V4l2Camera
    >>> with V4l2Camera('/dev/video0') as camera:  # doctest: +SKIP
    ...     camera.read(timeout=1.0)
    Traceback (most recent call last):
        ...
    blob_tracker.capture.errors.NoFrameError: /dev/video0: no frame for 1.0 s

    """
