"""
OpenCV 5 changed array shapes: what works with the pinned 4 must work with it too.

Each file that calls OpenCV has its tests run with OpenCV 5 in front of the pinned one. What calls
none gives the same with either, and is not run again.
"""

from __future__ import annotations

import os
from pathlib import Path
import re
import subprocess
import sys

import blob_tracker
import pytest

HERE = Path(__file__).parent
PACKAGE = Path(blob_tracker.__file__).parent
OPENCV5 = Path(sys.prefix) / 'opencv5'  # `make test` puts it there
# The file that calls OpenCV -> the tests that take each of its calls.
TESTS = {
    'calibration/board.py': [
        'calibration/test_board.py::test_a_fish_eye_is_recovered',
        'calibration/test_board.py::test_a_wrong_view_is_left_out_and_told_of',
        'calibration/test_board_advice.py',
    ],
    'calibration/board_views.py': ['calibration/test_board_views.py'],
    'calibration/boards/charuco.py': ['calibration/test_boards.py'],
    'calibration/boards/chessboard.py': ['calibration/test_boards.py'],
    'calibration/boards/dot_grid.py': ['calibration/test_boards.py'],
    'calibration/boards/regularity.py': ['calibration/test_regularity.py'],
    'calibration/dot_centres.py': ['calibration/test_boards.py'],
    'calibration/edge.py': [
        'calibration/test_trailing_edge.py::test_falling_edges_serve_as_well',
        'calibration/test_trailing_edge.py::test_no_filter_is_found_as_none',
    ],
    'calibration/frame_pair.py': [
        'calibration/test_photon_transfer.py::test_a_hot_pixel_costs_no_pair',
        'calibration/test_photon_transfer.py::test_processed_frames_are_warned_of',
    ],
    'calibration/response_measurement.py': ['calibration/test_response_flats.py'],
    'camera/lens/equidistant.py': ['camera/lens/test_equidistant.py'],
    'camera/lens/numerical.py': ['camera/lens/test_another_lens.py'],
    'camera/lens/plumb_bob.py': [
        'calibration/test_board.py::test_a_wrong_view_is_left_out_and_told_of',
    ],
    'camera/lens/polynomial.py': ['camera/lens/test_polynomial.py'],
    'camera/response.py': ['camera/test_response.py'],
    'capture/exposure.py': [
        'capture/test_exposure.py::test_a_red_light_is_not_clipped_in_red',
        'capture/test_exposure.py::test_too_much_light_is_told',
    ],
    'capture/picture.py': ['capture/test_picture.py'],
    'capture/pixel_formats/jpeg.py': ['capture/pixel_formats/test_jpeg.py'],
    'capture/pixel_formats/rgb.py': ['capture/pixel_formats/test_rgb.py'],
    'commands/sources/video.py': ['commands/sources/test_video.py'],
    'commands/track/annotated.py': ['commands/track/test_annotated.py'],
    'colour.py': ['test_colour.py'],
    'drawing.py': ['test_drawing.py'],
    'location/picture.py': ['location/test_picture.py'],
    'ros/messages/compressed_image.py': ['ros/messages/test_compressed_image.py'],
    'ros/parameters/mask.py': ['ros/parameters/test_mask.py'],
    'segmentation/black_core.py': [
        'segmentation/test_bright_lights.py::test_a_black_core_is_left_out',
    ],
    'segmentation/box.py': ['segmentation/test_box.py'],
    'segmentation/channel.py': ['segmentation/test_channel.py::test_the_first_flash_is_not_lost'],
    'segmentation/contrast.py': ['segmentation/test_contrast.py'],
    'segmentation/glitter.py': [
        'segmentation/test_glitter.py::test_a_lamp_that_flickers_at_one_place_is_not_taken',
    ],
    'segmentation/lock_in.py': ['segmentation/test_lock_in.py::test_every_block_shows_the_light'],
    'segmentation/picture.py': [
        'segmentation/test_picture.py::test_a_target_at_the_edge',
        'segmentation/test_picture.py::test_a_window_is_drawn_about_its_pixels',
        'segmentation/test_picture.py::test_candidates_and_region_have_colours_of_their_own',
        'segmentation/test_picture.py::test_long_text_stays_inside',
    ],
    'segmentation/registration/alignment.py': [
        'segmentation/test_registration.py::test_a_few_lights_in_the_dark_are_enough',
        'segmentation/test_registration.py::test_a_shift_with_a_turn_is_found',
        'segmentation/test_registration.py::test_frames_with_nothing_in_common_give_a_reason',
    ],
    'segmentation/registration/warp.py': [
        'segmentation/test_registration.py::test_a_box_is_that_part_of_the_whole',
        'segmentation/test_registration.py::test_the_overlap_is_where_both_frames_were',
        'segmentation/test_registration.py::'
        'test_what_is_laid_over_is_what_the_camera_would_have_seen',
    ],
    'simulation/board.py': [
        'simulation/test_board.py::test_a_disc_of_ink_lies_where_the_truth_says',
        'simulation/test_board.py::test_area_and_levels_are_those_of_the_board',
        'simulation/test_board.py::test_noise_is_the_sensor_s_and_the_seed_repeats_it',
    ],
    'simulation/camera_motion.py': ['simulation/test_camera_motion.py'],
    'simulation/pan_tilt_camera.py': ['simulation/test_pan_tilt_camera.py'],
    'simulation/scene.py': ['simulation/test_scene.py'],
    'simulation/wall.py': ['simulation/test_pan_tilt_camera.py'],
}
# They read and write image files by the name: every version does.
FILES_ALONE = {'commands/calibrate/board.py', 'commands/sources/folder.py'}


def test_each_file_that_calls_opencv_is_listed() -> None:
    """A new one has to name its tests."""
    callers = {
        path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob('*.py')
        if re.search(r'^ *import cv2\b', path.read_text(), re.M)
    }
    assert callers - FILES_ALONE == set(TESTS)


def test_what_calls_opencv_works_with_opencv_5() -> None:
    """Its tests pass with it in front of the pinned one."""
    if not OPENCV5.is_dir():
        reason = f'no OpenCV 5 in {OPENCV5}: make test installs it'
        if os.environ.get('CI'):
            pytest.fail(reason)
        pytest.skip(reason)
    path = os.pathsep.join([str(OPENCV5), *os.environ.get('PYTHONPATH', '').split(os.pathsep)])
    environment = dict(os.environ, PYTHONPATH=path)
    version = [sys.executable, '-c', 'import cv2; print(cv2.__version__)']
    found = subprocess.run(
        version, env=environment, cwd=OPENCV5, capture_output=True, text=True, check=True
    )
    assert found.stdout.startswith('5.')
    tests = [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider']
    tests += sorted({str(HERE / name) for names in TESTS.values() for name in names})
    tests += ['-k', 'not draws']  # a hundred boards for statistics make no other calls than three
    result = subprocess.run(tests, env=environment, cwd=HERE, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout[-4000:]
    assert ' passed' in result.stdout
