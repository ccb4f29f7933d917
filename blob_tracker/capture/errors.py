"""What goes wrong between the light and the frame."""


class CaptureError(RuntimeError):
    """No frame can be had; the message says what is wrong and what would be right."""


class NoFrameError(CaptureError):
    """No frame came in time; the camera may be read again."""
