"""The file of a learned pulse: what `calibrate pulse` writes and the locator reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from blob_tracker.camera.yaml_file import CalibrationError, check_size, YamlFile
from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.learn_pulse import Learned, WIDEST_GAP
from blob_tracker.location.pulse_rounds import LEAST_WINDOWS
from blob_tracker.types import SensorNoise
import numpy as np


@dataclass(frozen=True)
class PulseFile(YamlFile):
    """
    A learned pulse and the camera that it was learned with.

    Parameters
    ----------
    learned : Learned
        The pulse, and what it was learned from.
    width, height : int
        Of the camera's picture, px.
    light : str
        What the light and the camera's channel were, in the user's words: '850 nm, mono'.

    Raises
    ------
    CalibrationError
        If the pulse was learned from too little, or a value is invalid.

    """

    KIND = 'learned pulse'

    learned: Learned
    width: int
    height: int
    light: str = ''

    def __post_init__(self) -> None:
        if self.learned.windows < LEAST_WINDOWS:
            raise CalibrationError(
                f'the pulse was learned from {self.learned.windows} windows; it takes '
                f'{LEAST_WINDOWS}: record more flashes'
            )
        if not self.learned.gap <= WIDEST_GAP:
            raise CalibrationError(
                f'the windows of the pulse leave {self.learned.gap:.2f} px of the pixel empty, '
                f'{WIDEST_GAP:g} px at most will do: let the target move over many pixels'
            )
        if self.width < 1 or self.height < 1:
            raise CalibrationError(f'a picture of {self.width} x {self.height} px has no pulse')

    @classmethod
    def _of_content(cls, content: dict[str, Any]) -> PulseFile:
        try:
            pulse = EffectivePsf(
                np.array(content['coefficients'], dtype=float),
                float(content['step']),
                float(content['sigma']),
                np.array(content['covariance'], dtype=float),
                bool(content['varies']),
            )
            noise = SensorNoise(*(float(content[name]) for name in _NOISE))
        except ValueError as error:
            raise CalibrationError(str(error)) from None
        learned = Learned(
            pulse, int(content['windows']), float(content['gap']), float(content['gain']),
            float(content['chi2']), noise,
        )
        return cls(
            learned, int(content['image_width']), int(content['image_height']),
            str(content['light']),
        )

    def _content(self) -> dict[str, Any]:
        learned, pulse = self.learned, self.learned.pulse
        return {
            'image_width': self.width,
            'image_height': self.height,
            'light': self.light,
            'windows': learned.windows,
            'gap': round(learned.gap, 4),
            'gain': round(learned.gain, 4),
            'chi2': round(learned.chi2, 4),
            **{name: float(getattr(learned.noise, name.partition('.')[2])) for name in _NOISE},
            'sigma': round(pulse.sigma, 6),
            'varies': pulse.varies,
            'covariance': pulse.covariance.tolist(),
            'step': pulse.step,
            'coefficients': np.round(pulse.coefficients, 6).tolist(),
        }

    def check_size(self, width: int, height: int) -> None:
        """Raise CalibrationError unless the sensor is of the size that was learned with."""
        check_size('pulse', (self.width, self.height), (width, height))


_NOISE = ('noise.gain', 'noise.read_noise', 'noise.black_level')
