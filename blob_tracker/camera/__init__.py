"""Location -> Bearing: from pixels to milliradians."""

from blob_tracker.camera.calibration_reader import read_calibration, Region
from blob_tracker.camera.calibration_writer import write_calibration
from blob_tracker.camera.data_sheet import DataSheet
from blob_tracker.camera.lens import LensError
from blob_tracker.camera.model import CameraModel, compile_lens, pinhole_matrix
from blob_tracker.camera.yaml_file import CalibrationError

__all__ = [
    'CalibrationError',
    'CameraModel',
    'compile_lens',
    'DataSheet',
    'LensError',
    'pinhole_matrix',
    'read_calibration',
    'Region',
    'write_calibration',
]
