"""Calibrations that are known and not read: by what each is told, and what to do."""

from __future__ import annotations

import re
from typing import Any

REMEDY = (
    'write its numbers as ROS YAML (image_width, image_height, camera_matrix, distortion_model, '
    'distortion_coefficients), or calibrate with `python3 -m blob_tracker calibrate board`'
)
# Names of values, by pattern, of which one is in the file.
_FORMS = (
    ('VINS-Mono, VINS-Fusion or camodocal', r'projection_parameters|mirror_parameters'),
    ('VINS-Mono or VINS-Fusion (its estimator, not its camera)', r'cam0_calib|imu_topic|max_cnt'),
    ('ORB-SLAM', r'Camera1?\.(fx|type|bf)|ORBextractor\..*'),
    ('OpenVSLAM or stella_vslam', r'Camera\.(model|setup|cols)|Camera|Feature'),
    ('OpenVINS (its estimator: give the file that relative_config_imucam names)',
     r'relative_config_imu(cam)?|use_fej'),
    ('Kalibr (its target or its IMU, not the camchain)',
     r'target_type|accelerometer_noise_density'),
    ('Metashape or PhotoScan', r'calibration|document'),
    ('MATLAB', r'IntrinsicMatrix|RadialDistortion|cameraParams|FocalLength'),
    ('LSD-SLAM or DSO', r'RadTan|FOV'),
    ('librealsense', r'coeffs|ppx'),
    ('Azure Kinect', r'CalibrationInformation'),
    ('a rig of OpenCV or multical', r'cameras|camera_poses'),
    ('COLMAP', r'camera_id|CAMERA_ID'),
    ('py-OCamCalib (export calib_results.txt)', r'mapping_coefficients'),
    ('a camera node (its parameters, not its calibration)', r'.*ros__parameters.*'),
    ('OpenCV that holds the board or the corners, and no camera',
     r'(aruco|charuco|chess|board|image|calibration|nframes).*'),
)
_TEXTS = (
    ('COLMAP', r'# Camera list with one line of data per camera'),
    ('ZED', r'\[LEFT_CAM_'),
    ('LSD-SLAM or DSO', r'\A(RadTan|FOV|EquiDistant|KannalaBrandt|Pinhole)?[ \t]*'
     r'(-?[\d.]+[ \t]+){3,8}-?[\d.]+[ \t]*\n\d+[ \t]+\d+'),
    ("MATLAB (Bouguet's Calib_Results.m)", r'^(fc|cc|kc|alpha_c)\s*=\s*\['),
    ('MATLAB', r'cameraParameters|IntrinsicMatrix'),
    ('KITTI', r'^(P0|P_rect_0\d|S_0\d|calib_time):'),
    ('Videre or Bumblebee', r'^\[(left|right|external) camera\]'),
    ('a parameter file or a launch file', r'<launch|ros__parameters'),
)


def named_form(names: dict[str, Any]) -> str | None:
    """Return whose form named values are in, as the sentence that refuses them."""
    return next((
        f'is a file of {form}, which is not read: {REMEDY}' for form, pattern in _FORMS
        if any(re.fullmatch(pattern, name) for name in names)
    ), None)


def text_form(text: str) -> str | None:
    """Return whose form a text is in, as the sentence that refuses it."""
    return next((
        f'is a file of {form}, which is not read: {REMEDY}' for form, pattern in _TEXTS
        if re.search(pattern, text, re.M)
    ), None)
