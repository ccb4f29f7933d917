"""What a lens sees and resolves by its data sheet, and how far a light is seen with it."""

from __future__ import annotations

import argparse
import sys

from blob_tracker.camera import CalibrationError, DataSheet
from blob_tracker.commands import link_budget
from blob_tracker.radiometry import OpticsError
from blob_tracker.studies.chapters_2_to_4.lens_table import (
    computed, printed, THESIS_HEIGHT, THESIS_PIXEL, THESIS_WIDTH, WIDTH_IN_THE_TEXT,
)
from blob_tracker.units import MRAD
import numpy as np
from rich.console import Console
from rich.table import Table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker optics`."""
    parser.description = (
        "Without a lens' numbers: Table 2.1 of the thesis, computed and as printed. With them: "
        'what that lens sees, what a location in px is worth as an angle and at a range, and how '
        'far its data sheet can be trusted. With --led: how far that light is seen, by day and '
        'by night.'
    )
    lens = parser.add_argument_group('lens and sensor')
    lens.add_argument(
        '--focal-length', type=float, nargs='+', metavar='MM',
        help="one or more, mm; by default those of the thesis' table, with --led "
        f'{link_budget.CAMERA.focal_length:g}',
    )
    lens.add_argument(
        '--pixel', type=float, metavar='UM',
        help=f'pixel pitch, um (default {THESIS_PIXEL:g}, with --led '
        f'{link_budget.CAMERA.pixel:g})',
    )
    lens.add_argument(
        '--width', type=int, metavar='PX', help=f'of the sensor, px (default {THESIS_WIDTH})'
    )
    lens.add_argument(
        '--height', type=int, metavar='PX', help=f'of the sensor, px (default {THESIS_HEIGHT})'
    )
    parser.add_argument(
        '--resolution', type=float, default=0.05, metavar='PX',
        help='standard deviation of the location, px (default 0.05, the goal of the thesis)',
    )
    parser.add_argument(
        '--range', type=float, default=1000.0, metavar='M',
        help='distance of the target, m (default 1000)',
    )
    sheet = parser.add_argument_group('tolerances of the data sheet, plus and minus')
    sheet.add_argument(
        '--focal-length-tolerance', type=float, default=5.0, metavar='PERCENT',
        help='of the focal length (default 5)',
    )
    sheet.add_argument(
        '--pixel-tolerance', type=float, default=0.5, metavar='PERCENT',
        help='of the pixel pitch (default 0.5)',
    )
    sheet.add_argument(
        '--centre-tolerance', type=float, default=0.2, metavar='MM',
        help="of the optical axis' place on the sensor (default 0.2)",
    )
    link_budget.add_arguments(parser)


def main(arguments: argparse.Namespace) -> int:
    """
    Print the tables.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        0 done, 2 for an impossible number.

    """
    console = Console()
    if options := link_budget.in_vain(arguments):
        print(f'{", ".join(options)}: of a light, which --led gives', file=sys.stderr)
        return 2
    if arguments.led is not None:
        return _budget(console, arguments)
    own = (arguments.focal_length, arguments.pixel, arguments.width, arguments.height)
    try:
        for name in ('resolution', 'range'):
            value = getattr(arguments, name)
            if not 0.0 < value < np.inf:
                raise CalibrationError(f'--{name} is {value:g}; it must be above 0')
        sheets = [_sheet(arguments, length) for length in arguments.focal_length or printed()]
    except CalibrationError as error:
        print(error, file=sys.stderr)
        return 2
    if all(value is None for value in own):
        _print_comparison(console)
    _print_resolution(console, sheets, arguments.resolution, arguments.range)
    _print_trust(console, sheets)
    return 0


def _budget(console: Console, arguments: argparse.Namespace) -> int:
    """Print the link budget of a light; a usual machine-vision lens and sensor by default."""
    camera = link_budget.CAMERA
    lengths = arguments.focal_length or [camera.focal_length]
    try:
        if len(lengths) > 1:
            raise OpticsError('--led takes one --focal-length')
        link_budget.print_budget(
            console, arguments, lengths[0],
            camera.pixel if arguments.pixel is None else arguments.pixel,
        )
    except OpticsError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _sheet(arguments: argparse.Namespace, focal_length: float) -> DataSheet:
    """Return the data sheet of one lens."""
    return DataSheet(
        THESIS_WIDTH if arguments.width is None else arguments.width,
        THESIS_HEIGHT if arguments.height is None else arguments.height,
        focal_length,
        THESIS_PIXEL if arguments.pixel is None else arguments.pixel,
        focal_length_tolerance=1e-2 * arguments.focal_length_tolerance,
        pixel_tolerance=1e-2 * arguments.pixel_tolerance,
        centre_tolerance_mm=arguments.centre_tolerance,
    )


def _print_comparison(console: Console) -> None:
    """Print Table 2.1 beside what it is computed to be, and which sensor that is."""
    table = _table(
        'Table 2.1 of the thesis (page 12): resolution of 1 px',
        'f\nmm', 'least angle\nmrad', 'printed', 'field of view\ndegrees', 'printed',
        f'on {WIDTH_IN_THE_TEXT} mm\ndegrees',
    )
    same = 0
    rows = printed()
    for length, (angle, field) in rows.items():
        ours = computed(length)
        same += (ours[0] == angle) + (ours[1] == field)
        table.add_row(
            f'{length:g}', ours[0], angle, ours[1], field, computed(length, WIDTH_IN_THE_TEXT)[1]
        )
    console.print(table)
    width = 1e-3 * THESIS_WIDTH * THESIS_PIXEL
    console.print(
        f'{same} of {2 * len(rows)} values are those printed. They are those of {THESIS_WIDTH} '
        f'pixels of {THESIS_PIXEL:g} um, a sensor {width:.2f} mm wide (0.003205 m in eq. 2.2 is '
        f'half of it); the one of {WIDTH_IN_THE_TEXT} mm that the text speaks of would see the '
        'last column. 0.63 mrad at 16 mm is 0.62499992 rounded twice.\n'
    )


def _print_resolution(
    console: Console, sheets: list[DataSheet], resolution: float, distance: float
) -> None:
    """Print what each lens sees, and what a location is worth on its axis and at its edge."""
    first = sheets[0]
    table = _table(
        f'{first.width} x {first.height} px of {first.pixel_um:g} um: '
        f'{1e-3 * first.width * first.pixel_um:.2f} x {1e-3 * first.height * first.pixel_um:.2f} '
        f'mm\n{resolution:g} px at {distance:g} m',
        'f\nmm', 'f\npx', 'field of view\ndegrees', '1 px\nmrad',
        f'{resolution:g} px\nmrad', 'at the edge\nmrad', f'at {distance:g} m\nm',
    )
    for sheet in sheets:
        across, down = sheet.field_of_view()
        model = sheet.camera_model()
        middle, edge = (
            resolution * model.angles(x, model.matrix[1, 2])[2][0, 0]
            for x in (model.matrix[0, 2], sheet.width - 0.5)
        )
        table.add_row(
            f'{sheet.focal_length_mm:g}',
            f'{model.matrix[0, 0]:.1f}',
            f'{np.degrees(across):.2f} x {np.degrees(down):.2f}',
            _digits(sheet.angle(1.0)),
            _digits(middle),
            _digits(edge),
            _digits(MRAD * middle * distance),
        )
    console.print(table)
    console.print('Standard deviations; at the range across the line of sight, on the axis.\n')


def _print_trust(console: Console, sheets: list[DataSheet]) -> None:
    """Print the standard deviation of a bearing that the data sheet leaves."""
    first = sheets[0]
    table = _table(
        'Sigma of a bearing by the data sheet, mrad\n'
        f'focal length +- {100 * first.focal_length_tolerance:g} %, pixel +- '
        f'{100 * first.pixel_tolerance:g} %, axis +- {first.centre_tolerance_mm:g} mm',
        'f\nmm', 'on the axis', 'half-way out', 'at the edge', 'edge at\ndegrees',
    )
    for sheet in sheets:
        places = [sheet.angle(part * sheet.width) for part in (0.0, 0.25, 0.5)]
        table.add_row(
            f'{sheet.focal_length_mm:g}',
            *(_digits(sheet.bearing_sigma(angle)) for angle in places),
            f'{np.degrees(MRAD * places[-1]):.2f}',
        )
    console.print(table)
    console.print(
        'The same in every frame, and without the distortion of the lens: calibrate to be rid of '
        'it.'
    )


def _table(title: str, *headings: str) -> Table:
    """Return an empty table of numbers."""
    table = Table(title=title, title_justify='left')
    for heading in headings:
        table.add_column(heading, justify='right')
    return table


def _digits(value: float) -> str:
    """Return a number with three significant digits and no exponent."""
    return np.format_float_positional(
        value, 3, unique=False, fractional=False, trim='k'
    ).rstrip('.')
