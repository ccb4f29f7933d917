"""How a rolling shutter reads its lines, a parameter of all who look at pictures."""

from blob_tracker.ros.interface import Parameter

LONGEST_S = 0.01  # s a line: a picture of 480 lines takes 5 s

_MEANING = (
    'From the exposure of a line of the frames to that of the next, of a rolling shutter: '
    'calibrate line_time measures it. Below 0: the last line is read first. 0: '
)


def _line_time(nothing: str) -> Parameter:
    return Parameter(
        'line_time', 0.0, _MEANING + nothing, least=-LONGEST_S, most=LONGEST_S, unit='s'
    )


CAMERA_LINE_TIME = _line_time('a global shutter, or see rolling_shutter.')
LINE_TIME = _line_time('a global shutter, or what the camera in this process says.')
