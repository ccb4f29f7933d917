"""A picture of what a segmenter saw in one frame, for people."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import Any, NamedTuple

from blob_tracker.drawing import (
    blank, Colour, FOUND, GAP_PX, in_grey, LINE_PX, nearest_pixel, PAPER, paragraphs, Picture,
    REJECTED, side_by_side, stack, TEXT, text_width, titled, within, wrap, write,
)
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.detections import Detections
import numpy as np
from numpy.typing import NDArray

WINDOW: Colour = (0, 255, 255)
REGION: Colour = (255, 170, 70)

# px of a panel: small frames grow, large ones shrink
NARROWEST_PX, WIDEST_PX, HIGHEST_PX = 480, 800, 720
INSET_PX = 144  # px of the side of a zoomed window
LARGEST_RADIUS_PX = 80  # px of radius
MOST_INSETS = 3  # windows that are zoomed
MARGIN_PX = 3  # px of the frame about a zoomed window
LEAST_NOISE_DN, MOST_DN = 0.01, 65535.0  # DN that can be
STRETCH_SIGMA = 8.0  # standard deviations of the noise from grey to white
# DN of white, at least: the noise of a dark frame must not look like a scene
DIMMEST_WHITE_DN = 64.0
SAMPLES = 64  # pixels along either axis from which the brightness of the frame is told


class _Zoom(NamedTuple):
    """A part of the frame as it is drawn: its box, and picture pixels to one of the frame."""

    box: Box
    scale: float

    def place(self, x: float, y: float) -> tuple[int, int]:
        """Return the pixel of the picture for a place in the frame; far outside is cut."""
        return (
            nearest_pixel((x - self.box.x0 + 0.5) * self.scale - 0.5),
            nearest_pixel((y - self.box.y0 + 0.5) * self.scale - 0.5),
        )

    def outline(self, picture: Picture, box: Box, colour: Colour) -> None:
        """Draw the border of a box, its pixels inside."""
        import cv2  # no part of a start

        half = 0.5 - 0.5 / self.scale  # from the centre of a pixel to its last picture pixel
        first = self.place(box.x0 - half, box.y0 - half)
        last = self.place(box.x1 - 1 + half, box.y1 - 1 + half)
        cv2.rectangle(picture, first, last, colour, 1)


def draw(detections: Detections) -> Picture:
    """
    Draw frame, difference, what lit up and why it was rejected, window and state.

    On the left the frame with the searched region (blue) and the windows (yellow); on the right
    lit less unlit, grey where nothing changed and white or black at +-8 standard deviations of the
    noise, with the candidates numbered: green where they may be the target, orange where they were
    rejected. Below them the state, the windows zoomed (lit, unlit, difference), or what is about
    the strongest candidate if there is no window, and the candidates in words.

    Parameters
    ----------
    detections : Detections
        What the segmenter saw, in a frame of any size and depth.

    Returns
    -------
    (h, w, 3) uint8 array
        Blue, green and red; 984 to 1624 px wide, whatever the frame.

    """
    shape = detections.lit.shape
    whole = Box(0, 0, shape[1], shape[0])
    zoom = _Zoom(whole, _scale(*shape))
    brightest = _brightest(detections.lit)
    noise = within(detections.noise, LEAST_NOISE_DN, MOST_DN, 1.0)
    rise = _rise(detections, within(detections.background, -MOST_DN, MOST_DN, 0.0))
    frame = titled(
        in_grey(detections.lit, 0.0, brightest, zoom.scale),
        f'frame {shape[1]} x {shape[0]} px, white is {brightest:.0f} DN',
        NARROWEST_PX,
    )
    difference = titled(
        in_grey(rise, -STRETCH_SIGMA * noise, STRETCH_SIGMA * noise, zoom.scale),
        f'{"frame less its background" if detections.unlit is None else "lit less unlit"}, '
        f'grey to white is {STRETCH_SIGMA:g} x the noise of {noise:.2f} DN',
        NARROWEST_PX,
    )
    for panel in (frame[LINE_PX:], difference[LINE_PX:]):
        if detections.region != whole:
            zoom.outline(panel, detections.region, REGION)
        for box in detections.windows.values():
            zoom.outline(panel, box, WINDOW)
    taken = [
        (*zoom.place(box.x0, box.y0), *zoom.place(box.x1, box.y1))
        for box in detections.windows.values()
    ]
    _mark(difference[LINE_PX:], detections.candidates, zoom, taken)
    panels = np.hstack([frame, blank(frame.shape[0], GAP_PX), difference])
    insets = _insets(detections, rise, noise)
    words = panels.shape[1] - insets.shape[1] - GAP_PX
    room = max(insets.shape[0] // LINE_PX, 3)
    state = f'{detections.state}: {detections.reason or "target in view"}'
    in_words = paragraphs(_in_words(detections.candidates, words, room), words)
    below = side_by_side(insets, in_words)
    colour = FOUND if detections.windows else REJECTED
    said = [(state, colour), *((each, REJECTED) for each in detections.warnings)]
    parts = [panels, paragraphs(said, panels.shape[1]), below]
    return np.pad(stack(parts), [(0, 0), (GAP_PX, GAP_PX), (0, 0)], constant_values=PAPER[0])


def _scale(height: int, width: int) -> float:
    """Return how many pixels of a panel are one of the frame."""
    most = min(WIDEST_PX / width, HIGHEST_PX / height)
    if most < 1.0:
        return most
    return float(min(max(math.ceil(NARROWEST_PX / width), 1), math.floor(most)))


def _brightest(image: NDArray[Any]) -> float:
    """Return the DN that is shown white, but for a few pixels the brightest in the frame."""
    step = [max(side // SAMPLES, 1) for side in image.shape]
    value = float(np.percentile(image[::step[0], ::step[1]], 99.9))
    return max(value, DIMMEST_WHITE_DN) if math.isfinite(value) else DIMMEST_WHITE_DN


def _rise(detections: Detections, background: float) -> NDArray[np.float32]:
    """Return lit less unlit less background, DN."""
    lit = detections.lit.astype(np.float32)
    if detections.unlit is not None and detections.unlit.shape == detections.lit.shape:
        lit -= detections.unlit
    lit -= background
    return np.nan_to_num(lit)


def _mark(
    panel: Picture,
    candidates: Sequence[Candidate],
    zoom: _Zoom,
    taken: list[tuple[int, int, int, int]],
) -> None:
    """Circle and number the candidates; a number that finds no free place is left out."""
    import cv2

    for number, candidate in enumerate(candidates, 1):
        colour = REJECTED if candidate.rejected else FOUND
        x, y = zoom.place(candidate.x, candidate.y)
        radius = max(nearest_pixel(3.0 * candidate.sigma_major * zoom.scale), 6)
        radius = min(radius, LARGEST_RADIUS_PX)
        cv2.circle(panel, (x, y), radius, colour, 1, cv2.LINE_AA)
        for left, top in _places(x, y, radius, text_width(str(number))):
            label = (left, top, left + text_width(str(number)), top + LINE_PX)
            inside = left >= 0 and top >= 0 and label[2] <= panel.shape[1] and (
                label[3] <= panel.shape[0]
            )
            if inside and not any(_overlap(label, other) for other in taken):
                taken.append(label)
                write(panel, str(number), left, top, colour, outlined=True)
                break


def _places(x: int, y: int, radius: int, width: int) -> list[tuple[int, int]]:
    """Return where a number may stand by its circle, the best first: left and top, px."""
    return [
        place
        for reach in (radius + 2, 2 * radius + 2)
        for place in (
            (x + reach, y - LINE_PX // 2),
            (x - reach - width, y - LINE_PX // 2),
            (x - width // 2, y - reach - LINE_PX),
            (x - width // 2, y + reach),
        )
    ]


def _insets(detections: Detections, rise: NDArray[np.float32], noise: float) -> Picture:
    """Return the windows zoomed, one below the other; else what the strongest candidate is."""
    height, width = detections.lit.shape
    outline = WINDOW
    zoomed = [
        (f'{name or "window"} {box.x1 - box.x0} x {box.y1 - box.y0} px at ({box.x0}, {box.y0})',
         box)
        for name, box in detections.windows.items()
    ]
    if not zoomed and detections.candidates:
        strongest = max(detections.candidates, key=lambda candidate: candidate.snr)
        half = min(max(nearest_pixel(4.0 * strongest.sigma_major), 3), max(height, width))
        x, y = nearest_pixel(strongest.x), nearest_pixel(strongest.y)
        number = detections.candidates.index(strongest) + 1
        zoomed = [(f'candidate {number}', Box(x - half, y - half, x + half + 1, y + half + 1))]
        outline = REJECTED if strongest.rejected else FOUND
    rows = []
    for title, box in zoomed[:MOST_INSETS]:
        around = Box(
            max(box.x0 - MARGIN_PX, 0),
            max(box.y0 - MARGIN_PX, 0),
            min(box.x1 + MARGIN_PX, width),
            min(box.y1 + MARGIN_PX, height),
        )
        if around.x0 >= around.x1 or around.y0 >= around.y1:
            continue
        lit = np.nan_to_num(detections.lit[around.slices].astype(np.float32))
        black, white = float(lit.min()), max(float(lit.max()), float(lit.min()) + STRETCH_SIGMA)
        part = rise[around.slices]
        most = max(float(np.abs(part).max()), STRETCH_SIGMA * noise)
        shown: list[tuple[str, NDArray[Any], float, float]] = [
            ('lit', lit, black, white), ('difference', part, -most, most)
        ]
        if detections.unlit is not None and detections.unlit.shape == detections.lit.shape:
            unlit = detections.unlit[around.slices]
            shown.insert(1, ('unlit', unlit, black, white))
        zoom = _Zoom(around, INSET_PX / max(around.x1 - around.x0, around.y1 - around.y0))
        row = blank(2 * LINE_PX + INSET_PX, len(shown) * (INSET_PX + GAP_PX) - GAP_PX)
        write(row, title, 0, 0, TEXT)
        for index, (name, pixels, low, high) in enumerate(shown):
            grey = in_grey(pixels, low, high, zoom.scale)
            zoom.outline(grey, box, outline)
            left = index * (INSET_PX + GAP_PX)
            write(row, name, left, LINE_PX, TEXT)
            row[2 * LINE_PX:2 * LINE_PX + grey.shape[0], left:left + grey.shape[1]] = (
                grey[:INSET_PX, :INSET_PX]
            )
        rows.append(row)
    return stack(rows) if rows else blank(0, 0)


def _in_words(
    candidates: Sequence[Candidate], width: int, room: int
) -> list[tuple[str, Colour]]:
    """Return the candidates in so many lines of text at most, those that may be it first."""
    if not candidates:
        return [('nothing lit up', TEXT)]
    lines: list[tuple[str, Colour]] = []
    numbered = sorted(enumerate(candidates, 1), key=lambda item: bool(item[1].rejected))
    for count, (number, each) in enumerate(numbered):
        text = (
            f'{number}  SNR {each.snr:.1f}, {each.height:.0f} DN, sigma {each.sigma_major:.1f} x '
            f'{each.sigma_minor:.1f} px at ({each.x:.1f}, {each.y:.1f}): '
            f'{each.rejected or "may be the target"}'
        )
        colour = REJECTED if each.rejected else FOUND
        wrapped = [(line, colour) for line in wrap(text, width)]
        left = len(candidates) - count
        if len(lines) + len(wrapped) + (left > 1) > room:
            return [*lines, (f'and {left} more', TEXT)]
        lines += wrapped
    return lines


def _overlap(one: tuple[int, int, int, int], other: tuple[int, int, int, int]) -> bool:
    """Tell whether two rectangles of left, top, right, bottom share a pixel."""
    return (
        one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
    )
