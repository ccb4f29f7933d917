"""What goes wrong between the light and the frame."""


class CaptureError(RuntimeError):
    """No frame can be had; the message says what is wrong and what would be right."""
