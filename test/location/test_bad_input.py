"""Whatever the window: a LocationError with the reason, or a sound and finite answer."""

from typing import Any

from blob_tracker.location import compile_ahead, locate, locate_batch, METHODS
from blob_tracker.types import LocationError, SensorNoise, Window
from hypothesis import example, given, settings, strategies as st
from hypothesis.extra import numpy as arrays
import numpy as np
import pytest
from support.late_kernels import run_alone

NOISE = SensorNoise(gain=2.0, read_noise=1.5)
FAST = [method for method in METHODS if method != 'multi_gaussian_simplex']


def locate_or_say_why(lit, unlit=None, saturation=None, method='maximum_likelihood'):
    """Assert that the answer is sound; return it, or None where there is none."""
    try:
        found = locate(Window(lit, unlit, saturation=saturation), method=method, noise=NOISE)
    except LocationError as error:
        assert len(str(error)) > 10
        return None
    height, width = np.shape(lit)
    assert -0.5 <= found.x <= width - 0.5
    assert -0.5 <= found.y <= height - 0.5
    numbers = [found.amplitude, found.background, found.sigma, found.snr, found.chi2]
    assert np.isfinite(numbers).all()
    assert np.isfinite(found.covariance).all()
    assert (np.linalg.eigvalsh(found.covariance) > 0.0).all()
    return found


def blob(size=9, x=4.2, y=3.8, amplitude=150.0):
    """Return a rounded pulse on 10 DN."""
    rows, columns = np.mgrid[0:size, 0:size]
    return np.rint(10.0 + amplitude * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / 4.0))


WINDOWS = st.one_of(
    arrays.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9))),
    arrays.arrays(
        np.uint8, (7, 7), elements=st.sampled_from([0, 10, 11, 12, 254, 255]),
    ),
    arrays.arrays(np.uint16, (7, 9), elements=st.integers(0, 65535)),
    arrays.arrays(np.int32, (5, 6), elements=st.integers(-1000, 1000)),
    arrays.arrays(np.float64, (6, 5)),
    arrays.arrays(np.float32, (7, 7), elements=st.floats(-100, 1000, width=32)),
)


@pytest.mark.parametrize('method', FAST)
@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(lit=WINDOWS, saturated=st.booleans())
@example(lit=np.zeros((0, 0)), saturated=False)
@example(lit=np.zeros((1, 1)), saturated=False)
@example(lit=np.full((7, 7), 37, dtype=np.uint8), saturated=False)
@example(lit=np.full((7, 7), np.nan), saturated=False)
@example(lit=np.full((7, 7), 255, dtype=np.uint8), saturated=True)
@example(lit=np.full((7, 7), 1e308), saturated=False)
def test_any_window(method, lit, saturated):
    """Hold for any pixels, alone and with an unlit window."""
    saturation = 255 if saturated else None
    locate_or_say_why(lit, saturation=saturation, method=method)
    locate_or_say_why(lit, np.zeros_like(lit), saturation=saturation, method=method)
    locate_or_say_why(lit, lit[::-1], saturation=saturation, method=method)


@settings(max_examples=10, deadline=None, derandomize=True, database=None)
@given(lit=WINDOWS)
def test_any_window_by_the_simplex(lit):
    """Hold for the method that takes its time."""
    locate_or_say_why(lit, method='multi_gaussian_simplex')


@settings(max_examples=300, deadline=None, derandomize=True, database=None)
@given(
    x=st.floats(-1.0, 9.0), y=st.floats(-1.0, 9.0), amplitude=st.floats(1.0, 60000.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_pulse_anywhere(x, y, amplitude, seed):
    """Be right within six standard deviations, or say why not, for a pulse that is in view."""
    noise = np.random.default_rng(seed).standard_normal((9, 9))
    clean = blob(x=x, y=y, amplitude=amplitude)
    lit = np.rint(clean + noise * np.sqrt(clean / NOISE.gain + NOISE.read_noise**2))
    found = locate_or_say_why(lit)
    # Sampled, not integrated, it fits with a sigma that is narrower, and at the same place.
    if found is not None and 0.0 <= x <= 8.0 and 0.0 <= y <= 8.0 and amplitude > 100.0:
        error = np.array([found.x - x, found.y - y])
        assert error @ np.linalg.solve(found.covariance, error) < 36.0


@pytest.mark.parametrize(('lit', 'reason'), [
    (np.zeros((0, 0)), 'at least 3 x 3'),
    (np.zeros((1, 1)), 'at least 3 x 3'),
    (np.full((7, 7), 37), 'flat'),
    (np.full((7, 7), np.nan), 'NaN'),
    (np.where(blob() > 100.0, np.inf, blob()), 'NaN'),
    (np.full((7, 7), 255), 'saturated'),
    (np.where(np.eye(5) > 0.0, 40, 255), 'too few'),
    (np.zeros((7, 7, 3)), 'must have 2'),
    (np.zeros(7), 'must have 2'),
    (np.full((7, 7), 'a'), 'real numbers'),
    (np.full((7, 7), 1.0 + 1.0j), 'real numbers'),
    (None, 'real numbers'),
    ([[1, 2, 3], [1, 2]], 'not an array'),
])
def test_the_reason_is_named(lit, reason):
    """Say what is wrong."""
    with pytest.raises(LocationError, match=reason):
        locate(Window(lit, saturation=255), noise=NOISE)


def test_lit_and_unlit_of_different_shapes():
    """Name both shapes."""
    with pytest.raises(LocationError, match=r'\(1, 9, 9\).*\(1, 7, 7\)'):
        locate(Window(blob(), np.zeros((7, 7))), noise=NOISE)


def test_unknown_method():
    """Name the methods that there are."""
    with pytest.raises(LocationError, match='maximum_likelihood'):
        locate(Window(blob()), method='best', noise=NOISE)


@pytest.mark.parametrize('method', METHODS)
def test_same_answer_whatever_the_memory_layout(method):
    """Take 8 and 16 bits, floats, strides, Fortran order and read-only arrays alike."""
    lit = blob()
    locked = lit.copy()
    locked.flags.writeable = False
    wide = np.zeros((18, 18))
    wide[::2, ::2] = lit
    reference = locate(Window(lit), method=method, noise=NOISE)
    for same in (
        lit.astype(np.uint8), lit.astype(np.uint16), lit.astype(np.float32), locked,
        np.asfortranarray(lit), wide[::2, ::2], lit.tolist(),
    ):
        found = locate(Window(same), method=method, noise=NOISE)
        # Memory that is aligned otherwise is summed in another order; a search may end elsewhere.
        assert (found.x, found.y) == pytest.approx((reference.x, reference.y), abs=1e-4)


@pytest.mark.parametrize('method', METHODS)
def test_two_equal_peaks_and_a_peak_on_the_edge(method):
    """Be sound for windows that hold no single whole blob."""
    pair = np.maximum(blob(13, 3.0, 6.0), blob(13, 9.0, 6.0))
    locate_or_say_why(pair, method=method)
    locate_or_say_why(pair, np.full((13, 13), 10.0), method=method)
    for x, y in ((0.0, 4.0), (8.0, 8.0), (-0.4, 0.2), (4.0, 8.4)):
        locate_or_say_why(blob(x=x, y=y), method=method)
        locate_or_say_why(blob(x=x, y=y), np.full((9, 9), 10.0), method=method)


@pytest.mark.parametrize('method', METHODS)
def test_a_bad_window_does_not_spoil_the_stack(method):
    """Flag the bad rows and leave the others as they are alone."""
    stack = np.stack([blob(), np.full((9, 9), np.nan), blob(x=3.6), np.zeros((9, 9))])
    found = locate_batch(stack, method=method, noise=NOISE)
    assert found.ok.tolist() == [True, False, True, False]
    alone = locate_batch(stack[2:3], method=method, noise=NOISE)
    # Sums over a stack may be taken in another order.
    assert found.x[2] == pytest.approx(alone.x[0], abs=1e-9)


@pytest.mark.parametrize('method', METHODS)
def test_no_windows(method):
    """Return nothing for nothing."""
    found = locate_batch(np.zeros((0, 9, 9)), method=method, noise=NOISE)
    assert found.x.shape == (0,)
    assert found.covariance.shape == (0, 2, 2)


ODD_LIGHTS = """
import numpy as np
from blob_tracker.location import compile_ahead, Locator
from blob_tracker.types import SensorNoise, Window
from support.late_kernels import late_kernels
from support.lights import BACKGROUND, dragged, NOISE, pulse

compile_ahead(['maximum_likelihood'])
late = late_kernels()
random = np.random.default_rng(1)
shape = (19, 19)
y, x = np.indices(shape) - 9.0
disc = 100.0 * (np.hypot(x, y) < 5.0)
lights = {
    'round': pulse(shape, 9.2, 9.1), 'streak': dragged(shape, 6.0, 7.0, np.array([6.0, 4.0])),
    'tail': pulse(shape, 7.0, 7.0) + 0.6 * dragged(shape, 7.0, 7.0, np.array([4.0, 3.0])),
    'two': pulse(shape, 7.0, 8.0) + 0.6 * pulse(shape, 11.0, 9.0), 'disc': disc,
    'ring': disc * (np.hypot(x, y) > 2.5), 'glow': pulse(shape, 9.0, 9.0) + 20.0 + 1.5 * x,
    'bright': 8.0 * pulse(shape, 9.0, 9.0), 'faint': 0.1 * pulse(shape, 9.0, 9.0),
}
behind = {
    'dark': 0.0 * x, 'ghost': 0.3 * pulse(shape, 8.0, 9.5), 'lamp': 0.8 * pulse(shape, 13.0, 9.0),
    'texture': 20.0 * np.sin(x), 'cut': pulse(shape, 9.2, 9.1) * (y > 0.0),
}
for name, light in lights.items():
    for beside in behind.values():
        locator = Locator()
        for k in range(4):
            lit, unlit = (
                np.clip(random.normal(mean + BACKGROUND, 2.0), 0, 255).astype(np.uint8)
                for mean in (light + beside * (name == 'round'), beside)
            )
            for dark, sites in ((unlit, None), (None, None), (unlit, (x + y) % 2 == 0)):
                window = Window(lit, dark, 0, 0, 10**9 + k * 33_000_000, 255, sites=sites)
                try:
                    locator.locate(window, noise=NOISE)
                except ValueError:
                    pass
assert not late, late
"""


def test_compile_ahead_leaves_nothing_to_compile_for_odd_lights() -> None:
    """No light that is not round waits for the compiler: in a process of its own."""
    run_alone(ODD_LIGHTS)


def test_compile_ahead_leaves_nothing_to_compile():
    """Compile each kernel once, whatever the windows' type and options."""
    from blob_tracker.location.maximum_likelihood import _fit_all

    compile_ahead()
    for lit in (blob(), blob().astype(np.uint8), np.asfortranarray(blob())):
        locate(Window(lit), noise=NOISE)
        locate(Window(lit, lit // 2, saturation=200), noise=NOISE, elliptical=True)
    compiled: Any = _fit_all
    # Loaded without Numba, which then has no signature, or compiled by it.
    assert (getattr(compiled, 'count', 0) or len(compiled.signatures)) == 1
