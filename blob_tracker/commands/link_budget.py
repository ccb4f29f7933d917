"""`optics --led`: how far a light is seen, by day and by night."""

from __future__ import annotations

import argparse
from dataclasses import replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

from blob_tracker.radiometry import (
    Budget, Led, LEVELS, link_budget, OpticsError, Receiver, Surroundings,
)
from blob_tracker.radiometry.budget import LEAST_SNR, nearest
import numpy as np
from rich.console import Console
from rich.table import Table

STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # of the range, in the table
UNITS = {'kW': 1e3, 'mW': 1e-3, 'W': 1.0}
PLOTTED = 60  # ranges, from a thirtieth of it to ten times it
CAMERA, LIGHT, AIR = Receiver(), Led(1.0), Surroundings()  # for their defaults
# Option -> what it sets, how much of that one of its unit is, its unit, what it is.
LED_OPTIONS = {
    'efficiency': ('efficiency', 1.0, '', 'light that leaves it, as a part of its power'),
    'half-angle': ('half_angle', 1.0, 'DEGREES', 'from its axis to where it is half as bright'),
    'off-axis': ('off_axis', 1.0, 'DEGREES', 'from its axis to the camera'),
    'wavelength': ('wavelength', 1.0, 'NM', 'of its light'),
    'diameter': ('diameter', 1e-3, 'MM', 'of what shines'),
    'flash': ('flash', 1e-3, 'MS', 'how long it is on; 0 is for the whole exposure'),
}
CAMERA_OPTIONS = {
    'f-number': ('f_number', 1.0, 'F', 'of the lens'),
    'transmission': ('transmission', 1.0, '', 'of the lens'),
    'filter': ('filter_width', 1.0, 'NM', 'pass band about the wavelength; inf is no filter'),
    'filter-transmission': ('filter_transmission', 1.0, '', 'in its pass band'),
    'quantum-efficiency': ('quantum_efficiency', 1.0, '', 'electrons a photon at best'),
    'full-well': ('full_well', 1.0, 'E', 'electrons that a pixel holds'),
    'read-noise': ('read_noise', 1.0, 'E', 'electrons'),
    'exposure': ('exposure', 1e-3, 'MS', 'of a frame'),
    'blur': ('blur', 1.0, 'PX', 'sigma of the image of a point by focus and aberrations'),
}
AIR_OPTIONS = {
    'visibility': ('visibility', 1.0, 'KM', '50 very clear, 23 clear, 10 haze, 1 thin fog'),
    'albedo': ('albedo', 1.0, '', 'of the scene behind the light: grass 0.2, snow 0.8'),
    'texture': ('texture', 1.0, '', "sigma of the scene's pattern as a part of its mean"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of a link budget."""
    light = parser.add_argument_group('link budget of a light (with --led)')
    light.add_argument(
        '--led', type=watts, metavar='POWER',
        help='electrical power of an LED while it is on, as 3W or 500mW: prints electrons a '
        'flash, SNR, mrad, and whether daylight drowns it, at --range',
    )
    _add(light, LED_OPTIONS, LIGHT)
    _add(parser.add_argument_group('its camera'), CAMERA_OPTIONS, CAMERA)
    around = parser.add_argument_group('its surroundings')
    around.add_argument(
        '--light', choices=tuple(LEVELS), default=AIR.light,
        help=f'on the scene (default {AIR.light})',
    )
    around.add_argument('--sky', action='store_true', help='it is seen before the sky')
    _add(around, AIR_OPTIONS, AIR)
    around.add_argument(
        '--plot', type=Path, metavar='FILE', help='draw SNR and mrad against range, .png or .svg'
    )


def watts(text: str) -> float:
    """Return a power in W: 3W, 500mW or 3."""
    factor, word = 1.0, text
    for unit, worth in UNITS.items():
        if text.endswith(unit):
            factor, word = worth, text.removesuffix(unit)
            break
    try:
        return factor * float(word)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a power; write 3W, 500mW or 0.5kW"
        ) from None


def in_vain(arguments: argparse.Namespace) -> list[str]:
    """Return the options of a link budget that were given without --led."""
    if arguments.led is not None:
        return []
    given = [
        name for options, defaults in (
            (LED_OPTIONS, LIGHT), (CAMERA_OPTIONS, CAMERA), (AIR_OPTIONS, AIR),
        )
        for name, (field, *_) in options.items()
        if _given(arguments, {name: options[name]})[field] != getattr(defaults, field)
    ]
    given += ['sky'] if arguments.sky else []
    given += ['light'] if arguments.light != AIR.light else []
    given += ['plot'] if arguments.plot is not None else []
    return [f'--{name}' for name in given]


def print_budget(
    console: Console, arguments: argparse.Namespace, focal_length: float, pixel: float
) -> None:
    """
    Print what comes of a light at a range, and at ranges about it by day, dusk and night.

    Parameters
    ----------
    console : Console
        Where to print.
    arguments : Namespace
        Of a parser that `add_arguments` filled, with a `range`, m.
    focal_length : float
        mm.
    pixel : float
        Pitch, um.

    Raises
    ------
    OpticsError
        For an impossible number.

    """
    led, camera, around = asked(arguments, focal_length, pixel)
    budget = link_budget(led, camera, around, arguments.range)
    _print_what_is_reckoned(console, led, camera, around)
    _print_one(console, budget, arguments.range)
    if budget.full >= 1.0:
        shorter = fitted(led, camera, around, arguments.range)
        console.print(f'At {_time(budget.fitting_exposure)} nothing is clipped:')
        _print_one(console, shorter, arguments.range)
    _print_ranges(console, led, camera, around, arguments.range)
    if arguments.plot is not None:
        _draw(arguments.plot, led, camera, around, arguments.range)
        console.print(str(arguments.plot))


def asked(
    arguments: argparse.Namespace, focal_length: float, pixel: float
) -> tuple[Led, Receiver, Surroundings]:
    """Return light, camera and surroundings as `print_budget` is asked for them."""
    led = Led(power=arguments.led, **_given(arguments, LED_OPTIONS))
    camera = replace(
        CAMERA, focal_length=focal_length, pixel=pixel, **_given(arguments, CAMERA_OPTIONS)
    )
    around = Surroundings(
        light=arguments.light, sky=arguments.sky, **_given(arguments, AIR_OPTIONS)
    )
    return led, camera, around


def fitted(led: Led, camera: Receiver, around: Surroundings, distance: float) -> Budget:
    """Return the budget with the exposure made as short as the brightest pixel asks for."""
    first = link_budget(led, camera, around, distance)
    if first.fitting_exposure >= camera.exposure:
        return first
    return link_budget(led, camera.exposed(first.fitting_exposure), around, distance)


def _add(
    group: argparse._ArgumentGroup, options: dict[str, tuple[str, float, str, str]],
    defaults: object,
) -> None:
    """Declare options with numbers; each has the default of what it sets."""
    for name, (field, unit, metavar, words) in options.items():
        default = getattr(defaults, field) / unit
        group.add_argument(
            f'--{name}', type=float, default=default, metavar=metavar or 'PART',
            help=f'{words} (default {default:g})',
        )


def _given(
    arguments: argparse.Namespace, options: dict[str, tuple[str, float, str, str]]
) -> dict[str, Any]:
    """Return what options set, in its own units."""
    return {
        field: unit * getattr(arguments, name.replace('-', '_'))
        for name, (field, unit, *_) in options.items()
    }


def _print_what_is_reckoned(
    console: Console, led: Led, camera: Receiver, around: Surroundings
) -> None:
    """Say in three lines what goes into it."""
    filtered = (
        f'a filter of {camera.filter_width:g} nm' if isfinite(camera.filter_width)
        else 'no filter'
    )
    behind = 'the sky' if around.sky else f'a scene of albedo {around.albedo:g}'
    console.print(
        f'Light: {led.power:g} W, {led.wavelength:g} nm, {led.intensity():.3g} W/sr towards the '
        f'camera.\nCamera: {camera.focal_length:g} mm f/{camera.f_number:g}, {filtered}, '
        f'{camera.pixel:g} um, {_time(camera.exposure)}.\nSeen through {around.visibility:g} km '
        f'of visibility before {behind}; light: {around.light}.\n', highlight=False,
    )


def _print_one(console: Console, budget: Budget, distance: float) -> None:
    """Print what comes of it at one range."""
    table = Table(
        title=f'At {distance:g} m: {budget.verdict}', title_justify='left', show_header=False
    )
    table.add_column('', justify='left')
    table.add_column('', justify='right')
    rows = [
        ('electrons a flash', _number(budget.electrons)),
        ('irradiance before the lens', f'{budget.irradiance:.3g} W/m^2'),
        ('lost in the air', f'{1.0 - budget.transmittance:.0%}'),
        ('sigma of the blob', f'{budget.sigma:.2f} px'),
        ('electrons behind it, each pixel', _number(budget.background)),
        ('full well filled, by the background alone',
         f'{budget.full:.0%}, {budget.background_full:.0%}'),
        ('exposure that fits', _time(budget.fitting_exposure)),
    ]
    found = (
        (f'SNR, lit less unlit (found above {LEAST_SNR:g})', _number(budget.snr)),
        ('SNR of the lit frame alone', _number(budget.snr_one_frame)),
        ('gain of the flash', f'{budget.snr / budget.snr_one_frame:.3g}'),
        ('Cramer-Rao bound', f'{budget.bound_px:.3g} px, {budget.bound_mrad:.3g} mrad'),
    )
    clipped = budget.full >= 1.0  # what pixels that are full say of a light is nothing
    rows += [(name, 'none: pixels are full' if clipped else value) for name, value in found]
    for row in rows:
        table.add_row(*row)
    console.print(table)


def _print_ranges(
    console: Console, led: Led, camera: Receiver, around: Surroundings, distance: float
) -> None:
    """Print SNR and bound at ranges, by the light on the scene."""
    table = Table(
        title='SNR; mrad (Cramer-Rao bound), the exposure made shorter if pixels are full',
        title_justify='left',
    )
    table.add_column('m', justify='right')
    for light in LEVELS:
        table.add_column(light, justify='right')
    for step in STEPS:
        if step * distance < nearest(led, camera):
            continue
        budgets = [
            fitted(led, camera, replace(around, light=light), step * distance)
            for light in LEVELS
        ]
        table.add_row(f'{step * distance:g}', *(
            f'{_number(each.snr)}; {each.bound_mrad:.2g}' if each.snr >= LEAST_SNR else
            f'{each.snr:.2g}; -' for each in budgets
        ))
    console.print(table)
    console.print('One flash; the bound is on the optical axis, along either axis of the picture.')


def _draw(
    path: Path, led: Led, camera: Receiver, around: Surroundings, distance: float
) -> None:
    """Draw SNR and bound against range, by the light on the scene."""
    from matplotlib.figure import Figure
    ranges = np.geomspace(max(distance / 30.0, nearest(led, camera)), 10.0 * distance, PLOTTED)
    figure = Figure(figsize=(9.0, 4.0), layout='constrained')
    left, right = figure.subplots(1, 2)
    for light in LEVELS:
        budgets = [fitted(led, camera, replace(around, light=light), each) for each in ranges]
        snr = np.array([each.snr for each in budgets])
        bound = np.array([each.bound_mrad for each in budgets])
        style = '--' if light == 'night' else '-'  # it may lie on the line of dusk
        left.loglog(ranges, snr, style, label=light)
        right.loglog(ranges, np.where(snr >= LEAST_SNR, bound, np.nan), style, label=light)
    left.axhline(LEAST_SNR, color='grey', linestyle=':', label=f'found above {LEAST_SNR:g}')
    left.set(xlabel='range, m', ylabel='SNR, lit less unlit', ylim=(1.0, None))
    right.set(xlabel='range, m', ylabel='Cramer-Rao bound, mrad')
    for axes in (left, right):
        axes.grid(True, alpha=0.3)
    left.legend()
    try:
        figure.savefig(path, dpi=110)
    except (OSError, ValueError) as error:  # no such folder, no such format
        reason = error.strerror if isinstance(error, OSError) else error
        raise OpticsError(f'--plot {path}: {reason}') from error


def _number(value: float) -> str:
    """Return a number with three digits or more, and no exponent."""
    return f'{value:,.0f}' if value >= 100.0 else f'{value:.3g}'


def _time(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    if seconds == inf or seconds >= 1.0:
        return 'more than 1 s'
    return f'{1e3 * seconds:.3g} ms' if seconds >= 1e-3 else f'{1e6 * seconds:.3g} us'
