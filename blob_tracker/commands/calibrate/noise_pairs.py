"""Pairs of frames for photon transfer, from any of the sources."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from math import inf
from pathlib import Path

from blob_tracker.calibration.frame_pair import Pair, pair_of, PhotonTransferError
from blob_tracker.calibration.temporal_correlation import Succession
from blob_tracker.commands.calibrate.frame_index import find_index, INDEX, Light, read_index
from blob_tracker.commands.sources import (
    grey_frames, GreyFrame, is_folder, is_live, SourceError,
)
from blob_tracker.commands.sources.folder import open_images
from blob_tracker.commands.sources.response import response_of
from blob_tracker.commands.sources.shown_frames import shown_frames, with_bar
from blob_tracker.types import Pixels
from rich.console import Console

SAME = 0.05  # of the mean, and 5 DN, by which the two frames of a pair may differ in light
STEP = 0.02  # of the mean, and 1 DN, beyond which a stream of frames shows another step
LIVE_S = 60.0
MOST_PAIRS = 8  # of one step: more tell little that eight do not


def pairs_of(
    arguments: argparse.Namespace, console: Console, succession: Succession
) -> list[Pair]:
    """Return the pairs of any of the sources, whose frames a succession is shown in order."""
    folder = Path(arguments.source)
    if arguments.dark:
        dark = argparse.Namespace(**{**vars(arguments), 'source': arguments.dark})
        return [
            *(
                _pair(two, dark=each is dark)
                for each in (dark, arguments)
                # A topic ends anywhere.
                for two in in_twos(
                    watched(frames_of(each, console), succession, each is dark),
                    odd=is_live(each),
                )
            ),
        ]
    if not is_folder(arguments):
        pairs = _steps(
            image for _, image in watched(frames_of(arguments, console), succession)
        )
        console.print(f'{len(pairs)} pairs; the darkest step is taken for the dark one')
        return pairs
    index = find_index(folder)
    if index is None:
        raise SourceError(
            f'{folder} has no {INDEX}; write one (file,kind,exposure_ns,photons_per_pixel) or a '
            'descriptor of EMVA 1288, give the dark frames of these bright ones with --dark '
            'FOLDER, or say --scene if they show a still scene'
        )
    return _indexed(arguments, index, console, succession)


def watched(
    stream: Iterable[GreyFrame], succession: Succession, dark: bool = False
) -> Iterator[tuple[str, Pixels]]:
    """Yield names and pixels of the frames of a stream, and show them to a succession."""
    for each in stream:
        succession.add(each.pixels, dark)
        yield each.name, each.pixels


def frames_of(arguments: argparse.Namespace, console: Console) -> Iterator[GreyFrame]:
    """Yield the frames of a source, of a mosaic single samples, with a progress bar."""
    return shown_frames(
        arguments, console, f'frames of {arguments.source}', live_seconds=LIVE_S,
        interpolate=False,
    )


def in_twos(
    stream: Iterable[tuple[str, Pixels]], *, odd: bool = False
) -> Iterator[tuple[Pixels, Pixels]]:
    """Yield the frames two by two; one that is left over is an error where `odd` is not set."""
    count, held = 0, None
    for _, image in stream:
        count += 1
        if held is None:
            held = image
        else:
            yield held, image
            held = None
    if held is not None and not odd:
        raise PhotonTransferError(
            f'the number of frames, {count}, is odd; each light needs two'
        )


def _pair(two: tuple[Pixels, Pixels], *, dark: bool, exposure: float | None = None) -> Pair:
    """Return the statistics of a pair, or say that its frames do not belong together."""
    means = [float(each.mean()) for each in two]
    if abs(means[0] - means[1]) > SAME * min(means) + 5.0:
        raise PhotonTransferError(
            f'two frames that should be a pair have means of {means[0]:.0f} and {means[1]:.0f} DN;'
            ' sort the names so that the two frames of each light come one after the other'
        )
    return pair_of(*two, dark=dark, exposure=exposure)


def _steps(stream: Iterable[Pixels]) -> list[Pair]:
    """
    Return the pairs of a stream in which the light goes up or down in steps.

    A step is a run of frames of one mean; its first frame may be one in which the light changed,
    and is left out where there are three or more. The darkest step is dark.
    """
    runs: list[list[Pair]] = []
    run: list[Pair] = []
    held: Pixels | None = None
    mean, length = -inf, 0
    for image in stream:
        level = float(image.mean())
        if abs(level - mean) > STEP * mean + 1.0 or mean < 0.0:
            mean, length, held, run = level, 0, None, []
            runs.append(run)
        length += 1
        if length == 1 or len(run) == MOST_PAIRS:
            continue
        if held is None:
            held = image
        else:
            run.append(_pair((held, image), dark=False))
            held = None
    pairs = [pair for run in runs for pair in run]
    if not pairs:
        raise PhotonTransferError(
            'no step of the light lasts for three frames; hold each brightness longer'
        )
    darkest = min(each.mean for each in pairs)
    return [
        Pair(**{**vars(each), 'dark': each.mean <= darkest * (1.0 + STEP) + 1.0})
        for each in pairs
    ]


def _indexed(
    arguments: argparse.Namespace, index: Path, console: Console, succession: Succession
) -> list[Pair]:
    """Return the pairs of a folder by its index."""
    lights = read_index(index)
    bright = [light for light in lights.values() if light.kind == 'bright']
    # Of time and photons the one that tells the levels apart.
    photons = len({light.exposure_ns for light in bright}) < 2
    source = open_images(list(lights))
    stream = grey_frames(source, interpolate=False, response=response_of(arguments))
    held: dict[Light, Pixels] = {}
    paired: set[Light] = set()
    pairs = []
    for light, (_, _, image, _) in zip(lights.values(), with_bar(
        stream, source, arguments, console, f'frames of {index}'
    )):
        succession.add(image, light)
        if light not in held:
            held[light] = image
            continue
        pairs.append(_pair(
            (held.pop(light), image), dark=light.kind == 'dark',
            exposure=light.photons if photons else light.exposure_ns,
        ))
        paired.add(light)
    # One that is left over of three has shown whether they hang together.
    for light in held.keys() - paired:
        raise PhotonTransferError(
            f'{index}: there is one frame alone of the {light.words}; each light needs two'
        )
    return pairs
