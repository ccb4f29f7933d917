"""Parts of pictures for people: images in grey, lines of text, and how they are put together."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]  # (h, w, 3)
Colour = tuple[int, int, int]  # blue, green, red

PAPER: Colour = (32, 32, 32)
TEXT: Colour = (230, 230, 230)
FOUND: Colour = (90, 230, 90)
REJECTED: Colour = (40, 150, 255)
CLIPPED: Colour = (70, 70, 255)

FONT_SIZE = 0.45  # of OpenCV's sans-serif
LINE_PX = 19  # px from one line of text to the next
GAP_PX = 8  # px between the parts
FARTHEST_PX = 10_000.0  # px: where OpenCV still draws


def in_grey(image: NDArray[Any], black: float, white: float, scale: float) -> Picture:
    """
    Return an image in grey, larger or smaller.

    Parameters
    ----------
    image : (h, w) array
        DN; NaN is black.
    black, white : float
        DN of either.
    scale : float
        Pixels of the picture to one of the image: repeated where it is 1 or more, else averaged.

    Returns
    -------
    (round(scale h), round(scale w), 3) uint8 array
        Each side 1 at least.

    """
    import cv2  # no part of a start

    size = [max(round(scale * side), 1) for side in image.shape]
    way = cv2.INTER_NEAREST if scale >= 1.0 else cv2.INTER_AREA
    image = cv2.resize(np.ascontiguousarray(image), (size[1], size[0]), interpolation=way)
    grey = (image.astype(np.float32) - black) * (255.0 / max(white - black, 1e-9))
    if image.dtype.kind == 'f':
        grey = np.nan_to_num(grey, copy=False)
    shades = np.clip(grey, 0.0, 255.0).astype(np.uint8)
    return np.asarray(cv2.cvtColor(shades, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


def titled(shown: Picture, title: str, least: int) -> Picture:
    """Return a picture with a line of text above it, so many px wide at least."""
    height, width = shown.shape[:2]
    panel = blank(LINE_PX + height, max(width, least))
    write(panel, title, 0, 0, TEXT)
    panel[LINE_PX:, :width] = shown
    return panel


def paragraphs(lines: Sequence[tuple[str, Colour]], width: int) -> Picture:
    """Return lines of text in a picture so many px wide, wrapped where they are too long."""
    wrapped = [(part, colour) for text, colour in lines for part in wrap(text, width)]
    picture = blank(LINE_PX * len(wrapped), width)
    for index, (text, colour) in enumerate(wrapped):
        write(picture, text, 0, LINE_PX * index, colour)
    return picture


def wrap(text: str, width: int) -> list[str]:
    """Return the text in lines of at most so many px, but for a word that is longer."""
    lines: list[str] = []
    for word in text.split():
        longer = f'{lines[-1]} {word}' if lines else word
        if lines and text_width(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def text_width(text: str) -> int:
    """Return the width of a text, px."""
    import cv2

    return int(cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, FONT_SIZE, 1)[0][0])


def write(
    picture: Picture, text: str, left: int, top: int, colour: Colour, *, outlined: bool = False
) -> None:
    """Write a line of text with its top left corner at a pixel."""
    import cv2

    foot, font = (left, top + LINE_PX - 6), cv2.FONT_HERSHEY_SIMPLEX
    if outlined:
        cv2.putText(picture, text, foot, font, FONT_SIZE, (0, 0, 0), 3, cv2.LINE_AA)
    cv2.putText(picture, text, foot, font, FONT_SIZE, colour, 1, cv2.LINE_AA)


def blank(height: int, width: int) -> Picture:
    """Return an empty part of the picture."""
    # Of one number: all three are the same, and a row of three takes twenty times as long.
    return np.full((height, width, 3), PAPER[0], dtype=np.uint8)


def stack(parts: Sequence[Picture]) -> Picture:
    """Return parts one below the other, with a gap under each."""
    width = max(part.shape[1] for part in parts)
    height = sum(part.shape[0] + GAP_PX for part in parts)
    picture = blank(height, width)
    top = 0
    for part in parts:
        picture[top:top + part.shape[0], :part.shape[1]] = part
        top += part.shape[0] + GAP_PX
    return picture


def side_by_side(left: Picture, right: Picture) -> Picture:
    """Return two parts side by side."""
    height = max(left.shape[0], right.shape[0])
    picture = blank(height, left.shape[1] + GAP_PX + right.shape[1])
    picture[:left.shape[0], :left.shape[1]] = left
    picture[:right.shape[0], left.shape[1] + GAP_PX:] = right
    return picture


def nearest_pixel(value: float) -> int:
    """Return the nearest whole number, of those that OpenCV can draw at; 0 for none."""
    return round(within(value, -FARTHEST_PX, FARTHEST_PX, 0.0))


def within(value: float, least: float, most: float, otherwise: float) -> float:
    """Return a value within its bounds, or another for NaN."""
    return otherwise if math.isnan(value) else min(max(value, least), most)
