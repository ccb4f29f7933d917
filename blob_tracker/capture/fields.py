"""An interlaced picture -> its two fields, each a frame with a time of its own."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.capture import videodev2
from blob_tracker.types import BAYER, Frame, Pixels
import numpy as np

TOP, BOTTOM = 0, 1
# How a picture holds its fields, as V4L2_FIELD_... names it, in the order of time: the fields, and
# whether they lie line by line or one above the other.
ORDERS: dict[str, tuple[tuple[int, ...], bool]] = {
    'interlaced_tb': ((TOP, BOTTOM), True),
    'interlaced_bt': ((BOTTOM, TOP), True),
    'seq_tb': ((TOP, BOTTOM), False),
    'seq_bt': ((BOTTOM, TOP), False),
    'top': ((TOP,), False),
    'bottom': ((BOTTOM,), False),
}
LINES_OF_525 = (480, 486)  # of a picture by the standard of 525 lines, which begins at the bottom
MOST_ALONE = 8  # fields of one kind in a row, after which no other kind is waited for
LEAST_LINES = 4  # of a picture: its fields leave their last line out
ALTERNATE = 'alternate'  # the fields of a picture come one after the other, each by itself
SINGLE = (ALTERNATE, 'top', 'bottom')  # a buffer holds one field, and its lines are half as many
# What the driver may be asked for; '' is a whole picture, or else as it gives them.
CHOICES = ('', 'interlaced', *ORDERS, ALTERNATE)


def order_of(name: str, height: int, lines: int = 0) -> str:
    """
    Return the key of `ORDERS` for a V4L2 field order.

    Parameters
    ----------
    name : str
        One of `ORDERS`, or 'interlaced', whose order is that of the video standard: bottom first
        with 525 lines, top first with 625.
    height : int
        Lines of the picture.
    lines : int
        Those of the video standard, 525 or 625; 0 where it is not known, and `height` has to tell.

    Raises
    ------
    ValueError
        If there is no such order.

    Examples
    --------
    The order of a picture of 480 lines, in which the bottom field comes first, and of one of 576:

    >>> order_of('interlaced', 480), order_of('interlaced', 576)
    ('interlaced_bt', 'interlaced_tb')
    >>> order_of('woven', 480)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    ValueError: no field order 'woven'; there is interlaced, ...

    """
    if name == 'interlaced':
        of_525 = lines == 525 or (not lines and height in LINES_OF_525)
        return 'interlaced_bt' if of_525 else 'interlaced_tb'
    if name not in ORDERS:
        raise ValueError(f"no field order '{name}'; there is interlaced, {', '.join(ORDERS)}")
    return name


def fields(frame: Frame, order: str, interval_ns: int) -> tuple[Frame, ...]:
    """
    Deal the fields of a picture out.

    Line u of a field is taken to cover the lines o + 2 u and o + 2 u + 1 of the picture, as a
    camera sums them that integrates fields: o is 0 at the top and 1 at the bottom, the binning
    along y is 2, and y = y0 + 2 (u + 1/2) - 1/2. The last line of the bottom field, which reaches
    beyond the picture, is left out, and that of the top field, so that both have one size. So
    places are half a line below those in whole pictures, in which the line has the number
    o + 2 u: a calibration of whole pictures is that of the fields with half a line more in c_y.

    Parameters
    ----------
    frame : Frame
        The picture. Its stamp is the middle of the exposure of the first line of the field that
        was taken first, its line time that from a line of a field to the next of the same field.
        A picture in the order 'top' or 'bottom' is a field alone, its place and binning are those
        of the whole.
    order : str
        One of `ORDERS`, or 'interlaced': see `order_of`.
    interval_ns : int
        From picture to picture, ns: the second field is half of it later.

    Returns
    -------
    tuple of Frame
        In the order of time.

    Raises
    ------
    ValueError
        If there is no such order, the picture has fewer than four lines, or it is a mosaic.

    Examples
    --------
    The fields of a picture of 576 lines at 25 pictures a second:

    >>> picture = Frame(np.zeros((576, 720), np.uint8), stamp_ns=0, saturation=255)
    >>> first, second = fields(picture, 'interlaced_tb', interval_ns=40_000_000)
    >>> first.image.shape, first.y0, first.field
    ((287, 720), 0, 0)
    >>> second.y0, second.field, second.stamp_ns
    (1, 1, 20000000)

    """
    if frame.layout in BAYER or frame.mosaic is not None:
        raise ValueError('the lines of a Bayer mosaic are not fields; set the camera to grey')
    height = frame.image.shape[0]
    if height < LEAST_LINES:
        raise ValueError(f'a picture of {height} lines has no fields')
    kinds, woven = ORDERS[order_of(order, height)]
    dealt = []
    for place, kind in enumerate(kinds):
        if woven:
            image, lines = frame.image[kind::2], height
        else:
            rows = height // len(kinds)
            image, lines = frame.image[place * rows:(place + 1) * rows], 2 * rows
        across, down = frame.binning
        dealt.append(replace(
            frame,
            image=np.ascontiguousarray(image[:(lines - 1) // 2]),
            stamp_ns=frame.stamp_ns + place * (interval_ns // 2),
            y0=frame.y0 + kind * down,
            binning=(across, 2 * down),
        ))
    return tuple(dealt)


def woven(top: Pixels, bottom: Pixels, height: int) -> Pixels:
    """
    Put the fields of a picture between each other again.

    Parameters
    ----------
    top, bottom : (h, w) arrays
        Fields of `fields`.
    height : int
        Lines of the picture, 2 h or up to two more: those which the fields leave out are as the
        next ones above them in their field.

    Returns
    -------
    (height, w) array
        The picture.

    Examples
    --------
    Two fields of which the bottom one is brighter:

    >>> top, bottom = np.zeros((287, 720), np.uint8), np.full((287, 720), 9, np.uint8)
    >>> picture = woven(top, bottom, height=576)
    >>> picture[:4, 0].tolist(), picture.shape
    ([0, 9, 0, 9], (576, 720))

    """
    picture = np.empty((height, top.shape[1]), top.dtype)
    for kind, field in enumerate((top, bottom)):
        lines = picture[kind::2]
        lines[:len(field)] = field
        lines[len(field):] = field[-1]
    return picture


class Weaver:
    """
    Make pictures of the fields that come, for who needs no more than that the scene is at rest.

    What is no field is given back as it is; so are fields, where only one kind of them comes.

    Examples
    --------
    A top field waits for the bottom field:

    >>> weaver = Weaver()
    >>> weaver.add(np.zeros((287, 720), np.uint8), field=0, height=576)
    >>> weaver.add(np.zeros((287, 720), np.uint8), field=1, height=576).shape
    (576, 720)

    """

    def __init__(self) -> None:
        self._waiting: dict[int, Pixels] = {}
        self._alone = 0  # fields in a row that had no other beside them

    def add(self, pixels: Pixels, field: int | None, height: int) -> Pixels | None:
        """
        Take the next one; return a picture, or None if its other field is still to come.

        Parameters
        ----------
        pixels : (h, w) array
            DN.
        field : int or None
            See `field_of`.
        height : int
            Lines of the whole sensor; those of the picture, unless it is a part of that.

        """
        if field is None:
            return pixels
        self._waiting[field] = pixels
        if len(self._waiting) == 1:
            self._alone += 1
            return pixels if self._alone > MOST_ALONE else None
        top, bottom = self._waiting[TOP], self._waiting[BOTTOM]
        self._waiting.clear()
        self._alone = 0
        least = 2 * len(top)
        return woven(top, bottom, height if 0 < height - least <= 2 else least)

    def whole(self, frame: Frame, height: int) -> Frame | None:
        """
        Take the next frame; return that of the picture, or None, as `add` does.

        Parameters
        ----------
        frame : Frame
            Grey. The picture has the stamp of its later field.
        height : int
            Lines of the whole sensor.

        """
        field = frame.field
        picture = self.add(frame.image, field, height)
        if field is None or picture is None or picture is frame.image:
            return None if picture is None else frame
        across, down = frame.binning
        return replace(
            frame, image=picture, y0=frame.y0 - field * (down // 2), binning=(across, down // 2)
        )


class FieldStream:
    """
    The buffers of a stream as frames: whole pictures, or their fields.

    Parameters
    ----------
    name : str
        What the driver gives: 'none' (whole pictures), 'interlaced', `ALTERNATE` or one of
        `ORDERS`.
    height : int
        Lines of a buffer.
    lines : int
        Of the video standard, see `order_of`.

    Attributes
    ----------
    interlaced : bool
        Whether buffers hold fields.
    per_buffer : int
        Frames in a buffer, 1 or 2.
    per_picture : int
        Frames of a picture: 2 where both fields come.
    lines_per_line : int
        Lines of the picture for one of a buffer: 2 where buffers hold single fields.

    Examples
    --------
    A driver that gives both fields in a buffer, and one of whole pictures:

    >>> stream = FieldStream('interlaced', height=576)
    >>> stream.interlaced, stream.per_buffer, stream.order(0)
    (True, 2, 'interlaced_tb')
    >>> FieldStream('none', height=480).interlaced
    False

    """

    def __init__(self, name: str, height: int, lines: int = 0) -> None:
        self._order = name if name in ('none', ALTERNATE) else order_of(name, height, lines)
        kinds = {'none': 1, ALTERNATE: 1}.get(self._order) or len(ORDERS[self._order][0])
        self.interlaced = self._order != 'none'
        self.per_buffer = kinds
        self.per_picture = 2 if self._order == ALTERNATE else kinds
        self.lines_per_line = 2 if self._order in SINGLE else 1
        self._counts_pictures = False
        self._last: tuple[int, int] = -1, 0  # number and field of the last buffer
        self._second = 0  # the field that has the number of the one before

    def __str__(self) -> str:
        """Return the order in words."""
        if not self.interlaced:
            return 'none, whole pictures'
        if self._order == ALTERNATE:
            return 'one after the other'
        kinds, woven = ORDERS[self._order]
        words = ('top', 'bottom')
        if len(kinds) == 1:
            return f'{words[kinds[0]]} alone'
        lie = 'line by line' if woven else 'one above the other'
        return f'{words[kinds[0]]} before {words[kinds[1]]}, {lie}'

    def order(self, field: int) -> str:
        """
        Return the key of `ORDERS` for a buffer, 'none' for a whole picture.

        Parameters
        ----------
        field : int
            That of the buffer, which counts where fields alternate.

        Raises
        ------
        ValueError
            Fields alternate and the driver does not say which this is.

        """
        if self._order != ALTERNATE:
            return self._order
        name = videodev2.FIELDS[field] if field < len(videodev2.FIELDS) else str(field)
        if name not in ('top', 'bottom'):
            raise ValueError(f"the driver calls a field '{name}', not top or bottom")
        return name

    def number(self, sequence: int, field: int) -> int:
        """
        Return the number of a buffer in a count of buffers.

        By the rules of V4L2 both fields of a picture have its number where they alternate; some
        drivers count fields all the same. Two of one number tell which it is.

        Parameters
        ----------
        sequence, field : int
            As the driver gives them.

        """
        if self._order != ALTERNATE:
            return sequence
        if self._last[0] == sequence and self._last[1] != field:
            self._counts_pictures, self._second = True, field
        self._last = sequence, field
        return 2 * sequence + (field == self._second) if self._counts_pictures else sequence
