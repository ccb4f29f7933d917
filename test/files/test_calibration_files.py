"""Calibration files of other people's programs, each made here, its right values known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.__main__ import main
from blob_tracker.camera import CalibrationError, CameraModel, read_calibration, Region
import cv2
import numpy as np
import pytest
from support.calibration_files import OF_ROS
import yaml

K = np.array([[610.5, 0.0, 321.25], [0.0, 608.75, 238.5], [0.0, 0.0, 1.0]])
D = (-0.28, 0.09, 0.001, -0.0005, -0.01, 0.02, 0.003, -0.0004, 1e-5, 2e-5, 3e-5, 4e-5, 0.01, -0.02)


def assert_read(
    path: Path, model: str = 'plumb_bob', distortion: Any = D[:5], *, said: str = '',
    **options: Any,
) -> CameraModel:
    """Hold what a file gives against the camera, and what is said of it."""
    remarks: list[str] = []
    found = CameraModel.from_file(path, warn=remarks.append, **options)
    assert (found.width, found.height) == (640, 480)
    np.testing.assert_allclose(found.matrix, K, rtol=1e-12)
    assert found.distortion_model == model
    np.testing.assert_allclose(found.distortion, distortion, rtol=1e-12)
    assert [said in each for each in remarks] == ([True] if said else [])
    return found


def stored(path: Path, **values: Any) -> Path:
    """Write a file as OpenCV does."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in values.items():
        storage.write(name, value)
    storage.release()
    return path


def written(path: Path, text: str) -> Path:
    """Write a text."""
    path.write_text(text)
    return path


def refused(path: Path, sentence: str) -> None:
    """Hold that a file is refused in one line that names it and has no words of a parser."""
    with pytest.raises(CalibrationError, match=sentence) as caught:
        CameraModel.from_file(path)
    said = str(caught.value)
    assert str(path) in said
    for word in ('\n', '^', 'float', 'None', 'dict', 'reshape', 'Error', 'argument', "b'"):
        assert word not in said


@pytest.mark.parametrize('suffix', ['yml', 'yaml', 'xml', 'json'])
@pytest.mark.parametrize('count', [4, 5, 8, 12, 14])
def test_opencv(suffix: str, count: int, tmp_path: Path) -> None:
    """In each of its languages; the coefficients tell the model."""
    path = stored(
        tmp_path / f'camera.{suffix}', calibration_time='Mon 30 Nov 2026', nframes=20,
        image_width=640, image_height=480, camera_matrix=K,
        distortion_coefficients=np.array(D[:count]), avg_reprojection_error=0.21)
    assert_read(path, 'plumb_bob' if count < 8 else 'rational_polynomial', D[:count])


@pytest.mark.parametrize(('matrix', 'distortion', 'size'), [
    ('Camera_Matrix', 'Distortion_Coefficients', {'image_Width': 640, 'image_Height': 480}),
    ('cameraMatrix', 'distCoeffs', {'imageSize': np.array([640, 480])}),
    ('K', 'D', {'width': 640, 'height': 480}),
    ('mtx', 'dist', {'image_size': np.array([[640], [480]])}),
])
def test_names_that_programs_choose(
    matrix: str, distortion: str, size: dict[str, Any], tmp_path: Path
) -> None:
    """None is prescribed."""
    assert_read(stored(tmp_path / 'a.yml', **{matrix: K, distortion: np.array(D[:5])}, **size))


def test_opencv_5(tmp_path: Path) -> None:
    """It writes lists as matrices of one dimension, and another first line."""
    text = f"""%YAML 1.2
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 610.5, 0., 321.25, 0., 608.75, 238.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-nd-matrix
   sizes: [ 5 ]
   dt: d
   data: {list(D[:5])}
"""
    assert_read(written(tmp_path / 'a.yml', text))
    data = ' '.join(map(str, D[:5]))
    matrix = ' '.join(map(str, K.ravel()))
    assert_read(written(tmp_path / 'a.xml', f"""<?xml version="1.0"?>
<opencv_storage>
<image_width>640</image_width>
<image_height>480</image_height>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows><cols>3</cols><dt>d</dt><data>{matrix}</data></camera_matrix>
<distortion_coefficients type_id="opencv-nd-matrix">
  <sizes>5</sizes><dt>d</dt><data>{data}</data></distortion_coefficients>
</opencv_storage>
"""))


def test_fish_eyes_of_opencv(tmp_path: Path) -> None:
    """Its sample says so; where nothing does, four coefficients are said to be taken otherwise."""
    values: dict[str, Any] = {
        'image_width': 640, 'image_height': 480, 'distortion_coefficients': np.array(D[:4])}
    path = stored(tmp_path / 'a.yml', fisheye_model=1, camera_matrix=K, **values)
    assert_read(path, 'equidistant', D[:4])
    path = stored(tmp_path / 'b.yml', distortion_model='fisheye', K=K, **values)
    assert_read(path, 'equidistant', D[:4])
    path = stored(tmp_path / 'c.yml', mtx=K, **values)
    assert_read(path, 'plumb_bob', D[:4], said='taken for k1 k2 p1 p2')


def test_ros_with_the_tags_of_opencv(tmp_path: Path) -> None:
    """As ROS' YAML passed through FileStorage has them, R and P included."""
    text = '%YAML:1.0\n---\n' + OF_ROS.replace('_matrix:\n', '_matrix: !!opencv-matrix\n').replace(
        'coefficients:\n', 'coefficients: !!opencv-matrix\n').replace('  cols', '  dt: d\n  cols')
    plain = CameraModel.from_file(written(tmp_path / 'a.yaml', OF_ROS))
    tagged = CameraModel.from_file(written(tmp_path / 'b.yaml', text))
    for name in ('matrix', 'distortion', 'rectification', 'projection'):
        np.testing.assert_array_equal(getattr(plain, name), getattr(tagged, name))
    assert (tagged.name, tagged.distortion_model) == ('narrow_stereo', 'plumb_bob')


@pytest.mark.parametrize('name', ['plumb_bob', 'rational_polynomial'])
@pytest.mark.parametrize('count', [4, 5, 8, 12, 14])
def test_coefficients_under_either_name(name: str, count: int, tmp_path: Path) -> None:
    """They are of one polynomial; a name that does not fit has a word."""
    text = yaml.safe_dump({
        'image_width': 640, 'image_height': 480, 'distortion_model': name,
        'camera_matrix': {'rows': 3, 'cols': 3, 'data': K.ravel().tolist()},
        'distortion_coefficients': {'rows': 1, 'cols': count, 'data': list(D[:count])},
    })
    usual = 'plumb_bob' if count <= 5 else 'rational_polynomial'
    said = '' if name == usual else f'{name} with {count} coefficients is {usual}'
    assert_read(written(tmp_path / 'a.yaml', text), usual, D[:count], said=said)


INI = """# Camera intrinsics

[image]

width
640

height
480

[narrow_stereo]

camera matrix
610.5 0.0 321.25
0.0 608.75 238.5
0.0 0.0 1.0

distortion
-0.28 0.09 0.001 -0.0005 -0.01

rectification
1.0 0.0 0.0
0.0 1.0 0.0
0.0 0.0 1.0

projection
600.0 0.0 320.0 -7.5
0.0 601.0 240.0 0.0
0.0 0.0 1.0 0.0
"""


def test_ini_of_ros(tmp_path: Path) -> None:
    """With its name, R and P; one of two cameras is chosen by its name."""
    found = assert_read(written(tmp_path / 'ost.ini', INI))
    assert found.name == 'narrow_stereo'
    assert found.projection is not None and found.projection[0].tolist() == [600, 0, 320, -7.5]
    head, body = INI.split('[narrow_stereo]')
    both = written(tmp_path / 'ost.txt', head + f'[stereo/left]{body}\n[stereo/right]{body}')
    assert_read(both, camera='stereo/right')
    refused(both, 'is of several cameras, stereo/left, stereo/right: take one of them')
    refused(written(tmp_path / 'a.ini', INI.replace('height\n480', '')), 'has no height in its se')
    broken = written(tmp_path / 'a.ini', INI.replace('608.75', 'x'))
    refused(broken, 'camera matrix is not a number')


ECHOED = f"""header:
  stamp:
    sec: 1700000000
    nanosec: 5
  frame_id: optical
height: 480
width: 640
distortion_model: plumb_bob
d:
{''.join(f'- {each}{chr(10)}' for each in D[:5])}k:
{''.join(f'- {each}{chr(10)}' for each in K.ravel())}r:
{'- 0.0' + chr(10) + 8 * ('- 0.0' + chr(10))}p: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
binning_x: 2
binning_y: 2
roi:
  x_offset: 40
  y_offset: 20
  height: 400
  width: 560
  do_rectify: false
---
"""


def test_echoed_camera_info(tmp_path: Path) -> None:
    """Of ROS 2 and ROS 1; its roi and binning are said and kept."""
    path = written(tmp_path / 'a.yaml', ECHOED)
    found = assert_read(path, said='its images are binned 2 x 2, from the pixel (40, 20) on')
    assert found.rectification is None and found.projection is None
    assert read_calibration(path).region == Region(40, 20, 560, 400, (2, 2))
    of_ros_1 = ECHOED.replace('\nd:', '\nD:').replace('\nk:', '\nK:').replace('binning_x: 2', '')
    assert_read(written(tmp_path / 'b.yaml', of_ros_1), said='binned 1 x 2')
    refused(written(tmp_path / 'c.yaml', ECHOED.replace('width: 560', 'width: 601')),
            'roi of 601 x 400 px at .40, 20., which does not lie within the sensor of 640 x 480')
    refused(written(tmp_path / 'd.yaml', ECHOED.replace('610.5', '0.0')), 'focal lengths are 0')


def camchain(**camera: Any) -> str:
    """Return a camchain of Kalibr with one camera."""
    entry = {
        'cam_overlaps': [], 'camera_model': 'pinhole', 'distortion_coeffs': list(D[:4]),
        'distortion_model': 'radtan', 'intrinsics': [610.5, 608.75, 321.25, 238.5],
        'resolution': [640, 480], 'rostopic': '/cam0/image_raw',
    }
    return yaml.safe_dump({'cam0': entry | camera}, default_flow_style=None)


def test_kalibr(tmp_path: Path) -> None:
    """radtan, equidistant, none, the double sphere, both unified models; OpenVINS' first line."""
    path = tmp_path / 'camchain.yaml'
    assert_read(written(path, camchain()), 'plumb_bob', D[:4])
    assert_read(written(path, '%YAML:1.0\n' + camchain()), 'plumb_bob', D[:4])
    assert_read(written(path, camchain(distortion_model='equidistant')), 'equidistant', D[:4])
    none = {'distortion_model': 'none', 'distortion_coeffs': []}
    assert_read(written(path, camchain(**none)), 'plumb_bob', np.zeros(4))
    four = [610.5, 608.75, 321.25, 238.5]
    for kind, lens in (('ds', 'double_sphere'), ('eucm', 'eucm')):
        text = camchain(camera_model=kind, intrinsics=[0.55, 0.6, *four], **none)
        assert_read(written(path, text), lens, [0.55, 0.6])
    xi = 0.25
    text = camchain(camera_model='omni', intrinsics=[
        xi, 610.5 * (1 + xi), 608.75 * (1 + xi), 321.25, 238.5], **none)
    assert_read(written(path, text), 'eucm', [0.2, 1.0])
    for change, sentence in (
        ({'camera_model': 'omni', 'intrinsics': [1.0, *four]}, 'omni with the distortion radtan'),
        ({'distortion_model': 'fov'}, 'the camera model pinhole with the distortion fov'),
        ({'camera_model': 'bspline'}, 'has the camera model bspline, which is not known'),
        ({'intrinsics': four[:3]}, 'intrinsics of cam0 must be 4 numbers, not 3'),
    ):
        refused(written(path, camchain(**change)), sentence)
    both = yaml.safe_load(camchain())
    both['cam1'] = both['cam0']
    written(path, yaml.safe_dump(both))
    assert_read(path, 'plumb_bob', D[:4], camera='cam1')
    refused(path, 'is of several cameras, cam0, cam1')


@pytest.mark.parametrize(('kind', 'own', 'lens', 'distortion'), [
    ('ds', {'xi': -0.2, 'alpha': 0.6}, 'double_sphere', [-0.2, 0.6]),
    ('eucm', {'alpha': 0.6, 'beta': 1.1}, 'eucm', [0.6, 1.1]),
    ('ucm', {'alpha': 0.6}, 'eucm', [0.6, 1.0]),
    ('kb4', dict(zip(('k1', 'k2', 'k3', 'k4'), D)), 'equidistant', D[:4]),
    ('pinhole', {}, 'plumb_bob', np.zeros(4)),
    ('pinhole-radtan8', dict(zip(('k1', 'k2', 'p1', 'p2', 'k3', 'k4', 'k5', 'k6'), D)),
     'rational_polynomial', D[:8]),
])
def test_basalt(
    kind: str, own: dict[str, float], lens: str, distortion: Any, tmp_path: Path
) -> None:
    """Each of its cameras."""
    camera = {
        'camera_type': kind,
        'intrinsics': {'fx': 610.5, 'fy': 608.75, 'cx': 321.25, 'cy': 238.5} | own,
    }
    text = repr({'value0': {'intrinsics': [camera], 'resolution': [[640, 480]]}})
    path = written(tmp_path / 'calibration.json', text.replace("'", '"'))
    assert_read(path, lens, distortion)
    refused(written(path, path.read_text().replace(kind, 'bal')), 'the camera type bal')


OCAM = """#polynomial coefficients for the DIRECT mapping function (ocam_model.ss in MATLAB). \
These are used by cam2world

5 -2.2e+02 0.000000e+00 1.45e-03 -6.2e-07 3.7e-09 \n
#polynomial coefficients for the inverse mapping function (ocam_model.invpol in MATLAB). These \
are used by world2cam

3 330.0 200.0 10.0 \n
#center: "row" and "column", starting from 0 (C convention)

238.5 321.25

#affine parameters "c", "d", "e"

1.0003 -0.0002 0.0005

#image size: "height" and "width"

480 640

"""


def test_ocamcalib(tmp_path: Path) -> None:
    """Its rays are those of its own cam2world, in the optical frame."""
    model = CameraModel.from_file(written(tmp_path / 'calib_results.txt', OCAM))
    assert (model.width, model.height) == (640, 480)
    assert model.distortion_model == 'ocamcalib'
    pol = np.array([-220.0, 0.0, 1.45e-3, -6.2e-7, 3.7e-9])
    affine = np.array([[1.0003, -0.0002], [0.0005, 1.0]])
    for row, column in ((238.5, 321.25), (0.0, 0.0), (479.0, 600.0), (100.25, 300.5)):
        xp, yp = np.linalg.solve(affine, (row - 238.5, column - 321.25))
        expected = np.array([yp, xp, -np.polyval(pol[::-1], np.hypot(xp, yp))])
        ray = model.unproject(column, row)[0]
        np.testing.assert_allclose(
            ray / np.linalg.norm(ray), expected / np.linalg.norm(expected), atol=1e-14)
    refused(written(tmp_path / 'a.txt', OCAM[:OCAM.index('#affine')]), 'has no affine')
    refused(written(tmp_path / 'a.txt', OCAM.replace('5 -2.2', '6 -2.2')), 'announces 6 coeff')


@pytest.mark.parametrize(('text', 'form'), [
    ('%YAML:1.0\n---\nmodel_type: PINHOLE\nprojection_parameters:\n   fx: 460', 'VINS-Mono, '),
    ('%YAML:1.0\nCamera.type: "PinHole"\nCamera.fx: 458.6\n', 'ORB-SLAM'),
    ('%YAML:1.0\nCamera1.fx: 458.6\n', 'ORB-SLAM'),
    ('Camera:\n  name: a\n  setup: monocular\n  fx: 458\n', 'OpenVSLAM or stella_vslam'),
    ('%YAML:1.0\nuse_fej: true\nrelative_config_imucam: "kalibr.yaml"\n', 'OpenVINS'),
    ('target_type: aprilgrid\ntagCols: 6\n', 'Kalibr'),
    ('<?xml version="1.0"?><calibration><f>600</f></calibration>', 'Metashape'),
    ('fc = [ 657.3 ; 657.7 ];\ncc = [ 302.9 ; 242.6 ];\n', "MATLAB .Bouguet's"),
    ('{"IntrinsicMatrix": [[1, 2], [3, 4]]}', 'MATLAB'),
    ('# Camera list with one line of data per camera:\n1 SIMPLE_RADIAL 3072 2304 2559', 'COLMAP'),
    ('[LEFT_CAM_HD]\nfx=700\n', 'ZED'),
    ('P0: 7.2e+02 0.0 6.0e+02\nP1: 7.2e+02\n', 'KITTI'),
    ('0.535 0.669 0.493 0.500 0.897\n640 480\ncrop\n640 480\n', 'LSD-SLAM or DSO'),
    ('{"mapping_coefficients": [1, 2]}', 'py-OCamCalib'),
    ('/camera:\n  ros__parameters:\n    width: 640\n', 'a parameter file'),
])
def test_forms_that_are_known(text: str, form: str, tmp_path: Path) -> None:
    """They are named, with what to do."""
    refused(written(tmp_path / 'a.yaml', text), f'is a file of {form}.*, which is not read: write')


@pytest.mark.parametrize(('content', 'sentence'), [
    (b'PK\x03\x04', r'NumPy \(.npz\): write'),
    (b'\x93NUMPY', 'a file of NumPy'),
    (b'\x1f\x8b', 'an archive: unpack it'),
    (b'MATLAB 5.0 MAT-file', 'a file of MATLAB'),
    (b'\x80\x04', 'a pickle of Python'),
    (b'camera_name: caf\xe9', 'not text in UTF-8'),
    (b'', 'holds no named values'),
    (b'nothing: at all', 'is not a calibration that is known: write its numbers'),
    (b'a: [1, 2', 'is not YAML: line 1, '),
    (b'a:\tb: c', 'is not YAML: line 1, '),
    (b'a: \x01', 'is not YAML: it has characters'),
    (b'<opencv_storage><a>', 'is not XML: line 1'),
    (b'image_width: 640', 'has no image_height'),
    (b'image_width: 640\nimage_height: 480', 'has no camera_matrix'),
    (b'image_width: wide\nimage_height: 480', 'image_width is not a number: wide'),
    (b'mtx: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\ndist: [0]', 'has no image_width and image_'),
    (b'width: 4\nheight: 3\nK: {rows: 3, cols: 3}\nD: [0, 0, 0, 0]', 'K has no data'),
    (b'width: 4\nheight: 3\nK: [1, 2]\nD: [0, 0, 0, 0]', 'K must be 9 numbers, not 2'),
    (b'width: 4\nheight: 3\nK: 5\nD: [0, 0, 0, 0]', 'K is not a list of numbers: 5'),
    (b'width: 4\nheight: 3\nK: [1]', 'has no distortion_coefficients'),
    (b'M1: [1]\nM2: [1]', 'is of two cameras'),
])
def test_what_is_no_calibration(content: bytes, sentence: str, tmp_path: Path) -> None:
    """Each in one sentence."""
    path = tmp_path / 'a.yaml'
    path.write_bytes(content)
    refused(path, sentence)


def test_python_wrote_it(tmp_path: Path) -> None:
    """As the tutorial of OpenCV has it: lists within lists, tuples, exponents without a point."""
    text = f"""camera_matrix: !!python/tuple
- !!python/tuple [610.5, 0, 321.25]
- [0, 608.75, 238.5]
- [0, 0, 1]
dist_coeff: [[{', '.join(map(str, D[:5]))}]]
"""
    path = written(tmp_path / 'a.yaml', text)
    refused(path, '`python3 -m blob_tracker calibrate convert FILE --size 640x480`')
    assert_read(path, size=(640, 480))


def test_convert(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What comes out is read as what went in, roi and binning included."""
    source, out = written(tmp_path / 'a.yaml', ECHOED), tmp_path / 'out.yaml'
    assert main(['calibrate', 'convert', str(source), '--out', str(out)]) == 0
    said = capsys.readouterr()
    assert 'its images are binned 2 x 2' in said.err
    assert str(out) in said.out.replace('\n', '')
    assert_read(out, said='its images are binned 2 x 2')
    assert read_calibration(out).region == Region(40, 20, 560, 400, (2, 2))
    source = written(tmp_path / 'calib_results.txt', OCAM)
    assert main(['calibrate', 'convert', str(source), '--out', str(out)]) == 0
    before, after = CameraModel.from_file(source), CameraModel.from_file(out)
    assert before.angles(100.0, 50.0)[:2] == after.angles(100.0, 50.0)[:2]
    assert main(['calibrate', 'convert', str(tmp_path / 'none.yaml'), '--out', str(out)]) == 1
    assert 'cannot read the calibration' in capsys.readouterr().err
    assert main(['calibrate', 'convert', str(out), '--out', str(out)]) == 2
