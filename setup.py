"""The ament_python build of blob_tracker."""

from glob import glob
from runpy import run_path

from setuptools import find_packages, setup

NAME = 'blob_tracker'

setup(
    name=NAME,
    version='0.1.0',
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
        (f'share/{NAME}/examples', glob('examples/*.py')),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest'], 'cluster': ['distributed']},
    zip_safe=True,
    maintainer='blob_tracker maintainers',
    maintainer_email='maintainers@blob-tracker.example',
    description='Tracks a flashing light and publishes its bearing with its covariance',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            f'{node} = {NAME}.nodes.start:{node}'
            for node in run_path(f'{NAME}/nodes/__init__.py')['NODES']
        ],
    },
)
