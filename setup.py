"""
The build of blob_tracker: by colcon (ament_python), and by pip for machines without ROS.

What is needed without ROS stands here, and nowhere else: package.xml, requirements and `doctor`
are held against it by test/test_package.py.
"""

from glob import glob
from runpy import run_path
import sys

from setuptools import Extension, find_packages, setup

try:
    import numpy
except ImportError:  # when pip asks what the build needs
    numpy = None

NAME = 'blob_tracker'
# The oldest versions are those of Ubuntu 24.04.
DEPENDENCIES = [
    'PyYAML>=6.0',
    'matplotlib>=3.6',
    'numba>=0.58',
    'numpy>=1.26',
    'opencv-python-headless>=4.6',
    'rich>=13.7',
    'rosbags>=0.11',
    'scipy>=1.11',
]
EXTRAS = {
    'cluster': ['distributed'],
    'files': ['astropy>=6.1', 'tifffile>=2024.1'],  # FITS and TIFF, for track and calibrate
    'test': ['pytest', 'pytest-timeout', 'hypothesis'],
}
# A wheel has one command of its own name. The nodes are executables of ROS, in a folder that only
# `ros2 run` looks into; beside other people's programs a `camera` would be in the way.
FOR_PIP = not {'bdist_wheel', 'dist_info', 'editable_wheel'}.isdisjoint(sys.argv)
# Without a C compiler nothing is missing but memory and time: Numba is then imported at the start.
EXTENSIONS = [] if numpy is None else [
    Extension(
        f'{NAME}.kernel.direct', [f'{NAME}/kernel/direct.c'], optional=True,
        include_dirs=[numpy.get_include()],
    ),
]

setup(
    name=NAME,
    version='0.2.0',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={
        NAME: ['config/*', 'config/security/*', 'studies/runner/*.css', 'studies/printed/*.yaml'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        (f'share/{NAME}/config', glob('config/*.*')),
        (f'share/{NAME}/config/security', glob('config/security/*')),
        (f'share/{NAME}/launch', glob('launch/*.launch.py')),
        (f'share/{NAME}/examples', glob('examples/*.py') + glob('examples/*.urdf')),
    ],
    python_requires='>=3.10',
    install_requires=DEPENDENCIES,
    extras_require=EXTRAS,
    ext_modules=EXTENSIONS,
    setup_requires=['numpy'] if numpy is None else [],
    zip_safe=False,
    maintainer='blob_tracker maintainers',
    maintainer_email='maintainers@blob-tracker.example',
    description='Tracks a flashing light and publishes its bearing with its covariance',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [f'{NAME} = {NAME}.__main__:main'] if FOR_PIP else [
            f'{node} = {NAME}.nodes.start:{node}'
            for node in run_path(f'{NAME}/nodes/__init__.py')['NODES']
        ],
    },
)
