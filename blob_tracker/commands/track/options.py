"""The nodes' parameters as options of `track`, and from the nodes' own parameter files."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from blob_tracker.nodes.interface.camera import PARAMETERS as OF_CAMERA
from blob_tracker.nodes.interface.locator import PARAMETERS as OF_LOCATOR
from blob_tracker.nodes.interface.segmenter import PARAMETERS as OF_SEGMENTER
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.interface import Parameter
from blob_tracker.ros.parameters.values import check, not_allowed, unknown
import yaml

OF_NODE: dict[str, dict[str, Parameter]] = {
    node: {each.name: each for each in parameters}
    for node, parameters in (
        ('segmenter', OF_SEGMENTER), ('locator', OF_LOCATOR), ('camera', OF_CAMERA),
    )
}
# What needs other nodes beside it, or is for those who wait for topics.
LEFT_OUT = {
    each.name: each for each in (*OF_SEGMENTER, *OF_LOCATOR) if each.name in (
        'follow_prediction', 'lights', 'lost_after', 'noise.measure', 'noise.online',
        'pulse.learn', 'range.calibration_sigma', 'range.diameter', 'range.psf_sigma',
        'range.reference_distance', 'range.reference_flux',
    )
}
OF_CALIBRATION = ('camera_info_url', 'field_of_view')
PARAMETERS: dict[str, Parameter] = {
    **{
        each.name: each for each in (*OF_LOCATOR, *OF_SEGMENTER) if each.name not in LEFT_OUT
    },
    **{name: OF_NODE['camera'][name] for name in OF_CALIBRATION},
}
OPTIONS = {'camera_info_url': '--camera-info', 'field_of_view': '--field-of-view'}
FILE = 'ros__parameters'


def add_options(parser: argparse.ArgumentParser) -> None:
    """Declare an option for each parameter, and one for files of them."""
    parser.add_argument(
        '--camera-info', metavar='FILE', dest='camera_info_url',
        help="calibration, for the angles; by default a bag's own",
    )
    parser.add_argument(
        '--field-of-view', metavar='DEGREES', dest='field_of_view', type=_reader('field_of_view'),
        help='horizontal field of view by the data sheet, for a camera without a calibration',
    )
    parser.add_argument(
        '--params-file', '--noise', action='append', default=[], type=Path, metavar='FILE',
        help='parameter file of the nodes, or as `calibrate noise` and the others write it; may '
        'be given several times, the later one wins',
    )
    group = parser.add_argument_group(
        'parameters of the nodes segmenter and locator', 'More on each is in '
        'config/tracker.yaml. An option wins over a file.',
    )
    for name, parameter in PARAMETERS.items():
        if name in OF_CALIBRATION:
            continue
        what = parameter.description.partition('. ')[0].rstrip('.')
        allowed = f'{parameter.limits}; ' if parameter.limits else ''
        group.add_argument(
            f'--{name}', dest=name, type=_reader(name), metavar=_metavar(parameter),
            help=f'{what} ({allowed}default {parameter.value})'.replace('%', '%%'),
        )


def values_of(arguments: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    """
    Return the values of the parameters, and what is to be said about them.

    Raises
    ------
    ParameterError
        A file cannot be read, or a value is invalid.

    """
    values = {name: parameter.default for name, parameter in PARAMETERS.items()}
    notes = []
    for path in arguments.params_file:
        for name, value in of_file(path):
            if name not in LEFT_OUT:
                values[name] = value
            elif value != LEFT_OUT[name].default:
                notes.append(f'{name} of {path} is for nodes that run, and is left out')
    given = {name: getattr(arguments, name) for name in PARAMETERS}
    values.update({name: value for name, value in given.items() if value is not None})
    return values, notes


def of_file(path: Path) -> Iterator[tuple[str, Any]]:
    """
    Yield names and values of a parameter file, as far as they are of these nodes.

    Raises
    ------
    ParameterError
        It cannot be read, no node has such a parameter, or it may not have that value.

    """
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f'{path} cannot be read: {error}') from None
    except yaml.YAMLError as error:
        raise ParameterError(f'{path} is not YAML: {" ".join(str(error).split())}') from None
    nodes = content.items() if isinstance(content, dict) else ()
    sections = [
        (str(pattern).rpartition('/')[2], section[FILE]) for pattern, section in nodes
        if isinstance(section, dict) and isinstance(section.get(FILE), dict)
    ]
    if not sections:
        raise ParameterError(
            f'{path} is not a ROS parameter file: it has no node with {FILE} in it'
        )
    for node, section in sections:
        for name, value in _flat(section):
            yield from _known(node, name, value, path)


def _known(node: str, name: str, value: Any, path: Path) -> Iterator[tuple[str, Any]]:
    """Yield a value of a section, where it is of a parameter that counts here."""
    if name == 'use_sim_time' or name.startswith('qos_overrides.'):
        return
    if node == 'camera':
        parameter = OF_NODE[node].get(name) if name in OF_CALIBRATION else None
    elif node in OF_NODE:
        parameter = OF_NODE[node].get(name)
        if parameter is None:
            raise ParameterError(f'{path}: {unknown(name, OF_NODE[node])}')
    elif '*' in node:
        parameter = _any(name)
    else:
        return
    if parameter is not None:
        try:
            check(parameter, value)
        except ParameterError as error:
            raise ParameterError(f'{path}: {error}') from None
        yield name, value


def _any(name: str) -> Parameter | None:
    return OF_NODE['segmenter'].get(name) or OF_NODE['locator'].get(name) or PARAMETERS.get(name)


def _flat(section: Mapping[str, Any], before: str = '') -> Iterator[tuple[str, Any]]:
    """Yield the values of a section, groups within it by their dots."""
    for name, value in section.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{before}{name}.')
        else:
            yield f'{before}{name}', value


def _reader(name: str) -> Any:
    """Return what turns a word of the command line into a parameter's value."""
    parameter = PARAMETERS[name]
    kind: Any = type(parameter.default)

    def read(word: str) -> Any:
        try:
            if kind is bool:
                value: Any = {'true': True, 'false': False}.get(word.lower(), word)
            else:
                value = kind(word)
            check(parameter, value)
        except ParameterError as error:
            raise argparse.ArgumentTypeError(_of_a_word(error)) from None
        except ValueError:
            raise argparse.ArgumentTypeError(_of_a_word(not_allowed(parameter, word))) from None
        return value

    return read


def _of_a_word(error: ParameterError) -> str:
    """Return what is said of a word of the command line, where a number needs no point."""
    return str(error).replace('a number with a point', 'a number')


def _metavar(parameter: Parameter) -> str:
    if parameter.unit:
        return parameter.unit.upper().replace('/', '_PER_').replace('-', '')
    return {bool: 'BOOL', int: 'N', float: 'VALUE', str: 'TEXT'}[type(parameter.default)]
