"""Read a calibration file, ROS' own or another program's, by what is in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from blob_tracker.camera.calibration_files.basalt import is_basalt, read_basalt
from blob_tracker.camera.calibration_files.kalibr import cameras_of, read_kalibr
from blob_tracker.camera.calibration_files.matrices import read_matrices, read_region
from blob_tracker.camera.calibration_files.ocamcalib import is_ocamcalib, read_ocamcalib
from blob_tracker.camera.calibration_files.others import named_form, REMEDY, text_form
from blob_tracker.camera.calibration_files.ros_ini import is_ros_ini, read_ros_ini
from blob_tracker.camera.calibration_files.text import named_values, read_text
from blob_tracker.camera.yaml_file import CalibrationError


class Region(NamedTuple):
    """
    Which pixels of the sensor the images are of, as camera_info has it (REP 104).

    Parameters
    ----------
    x0, y0, width, height : int
        px of the whole sensor without binning; a width or height of 0 is all of it.
    binning : (int, int)
        Sensor pixels per image pixel along x and y.

    Examples
    --------
    The right half of a sensor of 1280 x 960 px, binned by 2:

    >>> region = Region(x0=640, y0=0, width=640, height=960, binning=(2, 2))
    >>> region.width // region.binning[0], region.height // region.binning[1]  # image px
    (320, 480)

    """

    x0: int
    y0: int
    width: int
    height: int
    binning: tuple[int, int]


class Calibration(NamedTuple):
    """
    What a calibration file says.

    Parameters
    ----------
    arguments : dict
        Of `CameraModel`: of the whole sensor without binning.
    region : Region or None
        Of the images, where they are not the whole sensor.
    remarks : list of str
        What its reader ought to know, a sentence each.

    """

    arguments: dict[str, Any]
    region: Region | None
    remarks: list[str]


def read_calibration(
    path: str | Path, *, camera: str = '', size: tuple[int, int] | None = None
) -> Calibration:
    """
    Read a calibration file.

    Parameters
    ----------
    path : str or Path
        YAML of ROS, where what its parser fills in may be missing (camera_name, distortion_model,
        rectification_matrix, projection_matrix), its .ini, or an echoed camera_info; YAML, XML or
        JSON of OpenCV; Kalibr's camchain, basalt's calibration.json, OCamCalib's
        calib_results.txt.
    camera : str
        Name of the camera that is meant in a file of several.
    size : (int, int), optional
        Width and height, px, that count where the file has none.

    Raises
    ------
    CalibrationError
        If the file is missing, lacks a value, or is in a form that is not read; one that is
        known is named.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from blob_tracker.camera import CameraModel, pinhole_matrix, write_calibration
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, 'camera.yaml')
    ...     write_calibration(path, CameraModel(640, 480, pinhole_matrix(600.0, 640, 480)))
    ...     found = read_calibration(path)
    >>> found.arguments['width'], found.arguments['matrix'][0, 0].item()  # px
    (640, 600.0)
    >>> read_calibration('nowhere.yaml')  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.camera.yaml_file.CalibrationError: cannot read the calibration nowhere.yaml: ...

    """
    text = read_text(path)
    remarks: list[str] = []
    region = None
    try:
        if is_ocamcalib(text):
            arguments = read_ocamcalib(text)
        elif is_ros_ini(text):
            arguments = read_ros_ini(text, camera)
        elif (form := text_form(text)) is not None:
            raise CalibrationError(form)
        else:
            arguments, region = _of_names(named_values(path, text), camera, size, remarks)
    except CalibrationError as error:
        sentence = str(error)
        raise CalibrationError(
            sentence if sentence.startswith(str(path)) else f'{path} {sentence}') from None
    return Calibration(arguments, region, [f'{path}: {each}' for each in remarks])


def _of_names(
    content: dict[str, Any], camera: str, size: tuple[int, int] | None, remarks: list[str]
) -> tuple[dict[str, Any], Region | None]:
    """Return what named values say."""
    if cameras_of(content):
        return read_kalibr(content, camera), None
    if is_basalt(content):
        return read_basalt(content, camera), None
    arguments = read_matrices(content, size, remarks)
    if arguments is None:
        raise CalibrationError(
            named_form(content) or f'is not a calibration that is known: {REMEDY}')
    found = read_region(content)
    if found is None:
        return arguments, None
    binning, (x0, y0, width, height) = found
    if x0 + max(width, 1) > arguments['width'] or y0 + max(height, 1) > arguments['height']:
        raise CalibrationError(
            f'has a roi of {width} x {height} px at ({x0}, {y0}), which does not lie within the '
            f'sensor of {arguments["width"]} x {arguments["height"]} px (REP 104)'
        )
    remarks.append(
        f'its images are binned {binning[0]} x {binning[1]}, from the pixel ({x0}, {y0}) on; K is '
        f'of the whole sensor, {arguments["width"]} x {arguments["height"]} px (REP 104)'
    )
    return arguments, Region(x0, y0, width, height, binning)
