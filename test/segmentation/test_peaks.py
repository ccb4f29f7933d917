"""The peaks of known pixels, with their fields."""

from __future__ import annotations

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.description import FIELDS
from blob_tracker.segmentation.peaks import _on_flank, FEW_CANDIDATES, measure_peaks
from blob_tracker.segmentation.search import NO_MASK
from blob_tracker.simulation import pixel_integrated_gaussian
import numpy as np
import pytest

SHAPE = (96, 128)
FLOOR = 0.4
EVEN = np.full(SHAPE, 40, np.uint8)


def lit_by(
    x: float, y: float, sigma: float, height: float, *, kind: type = np.uint8
) -> np.ndarray:
    """Return an even frame with a blob, rounded and without noise."""
    light = height * pixel_integrated_gaussian(SHAPE, x, y, sigma)
    return np.rint(40.0 + light).clip(0, np.iinfo(kind).max).astype(kind)


def peaks(
    lit: np.ndarray,
    unlit: np.ndarray = EVEN,
    *,
    mask: np.ndarray = NO_MASK,
    region: tuple[int, int, int, int] = (0, 0, SHAPE[1], SHAPE[0]),
    saturation: int = 255,
    alone: bool = False,
) -> list[Candidate]:
    """Return what rose by twelve of the least noise, 5 DN."""
    table = measure_peaks(
        lit, unlit, region, mask, FLOOR, 12.0, 7.0, 64.0, saturation, alone, False
    )[0]
    return [Candidate(*row) for row in table.tolist()]


def test_the_table_has_the_fields_of_a_candidate() -> None:
    """In their order; the last one is what a rule says of them."""
    assert Candidate._fields[FIELDS:] == ('rejected', 'tau', 'glimpse', 'unlit')


def test_fields_of_a_blob_are_those_of_its_pixels() -> None:
    """A blob on a pixel's centre, without noise: all but the rounding is known."""
    lit = lit_by(60.0, 40.0, 2.0, 100.0)
    found, = peaks(lit)
    assert found.peak == (60, 40)
    assert (found.x, found.y) == pytest.approx((60.0, 40.0), abs=0.02)
    assert found.sigma_x == found.sigma_y == pytest.approx(np.hypot(2.0, 0.29), rel=0.02)
    assert found.correlation == pytest.approx(0.0, abs=0.02)
    assert found.height == lit[40, 60] - 40
    assert found.neighbour_ratio == pytest.approx((lit[40, 61] - 40) / found.height)
    assert found.amplitude == pytest.approx(98.0, abs=1.0)
    assert found.noise == FLOOR
    assert (found.background, found.fall, found.unlit_amplitude, found.clipped) == (0.0,) * 4
    assert found.misfit < 0.02
    assert found.snr == pytest.approx(98.0 * np.sqrt(np.pi) * 2.02 / FLOOR, rel=0.03)


@pytest.mark.parametrize('place, fall', [
    (np.s_[38:42, 69:73], 30.0),  # as large as the light, 4 x 4 px
    (np.s_[40:41, 70:71], 30.0 / 16.0),  # a single pixel: a hot one that went out
    (np.s_[38:42, 89:93], 0.0),  # 30 px away: something else
])
def test_fall_is_that_of_what_is_as_large(place: tuple[slice, slice], fall: float) -> None:
    """From 40 to 10 DN beside a light of sigma 2 px."""
    lit = lit_by(60.0, 40.0, 2.0, 100.0)
    lit[place] = 10
    assert peaks(lit)[0].fall == fall


def test_what_stood_there_before_is_measured() -> None:
    """A lamp of 50 DN, and its clipped pixels where there are some."""
    lamp = lit_by(60.0, 40.0, 2.0, 50.0)
    found, = peaks(lit_by(60.0, 40.0, 2.0, 120.0), lamp)
    assert found.unlit_amplitude == pytest.approx(50.0, abs=3.0)
    assert found.amplitude == pytest.approx(70.0, abs=3.0)
    assert not found.clipped
    assert peaks(lit_by(60.0, 40.0, 2.0, 120.0), lamp, saturation=80)[0].clipped


def test_texture_is_that_of_the_scene_about_it() -> None:
    """Stripes of 12 DN up and down."""
    stripes = np.where(np.arange(SHAPE[1]) // 2 % 2, 12, -12).astype(float)
    light = 100.0 * pixel_integrated_gaussian(SHAPE, 60.0, 40.0, 2.0)
    unlit = np.rint(60.0 + np.zeros(SHAPE) + stripes).astype(np.uint8)
    found, = peaks(np.rint(unlit + light).astype(np.uint8), unlit)
    assert found.texture == pytest.approx(12.0, rel=0.1)


def test_of_equal_pixels_the_first_is_the_peak() -> None:
    """A plateau of 3 x 3 is one blob."""
    lit = EVEN.copy()
    lit[50:53, 70:73] = 140
    found, = peaks(lit)
    assert found.peak == (70, 50)
    assert (found.x, found.y) == pytest.approx((71.0, 51.0), abs=0.05)


def test_more_lights_than_few_are_each_found_once() -> None:
    places = [(x, y) for x in range(12, 128, 16) for y in range(12, 96, 16)]
    light = sum(lit_by(x, y, 1.3, 80.0).astype(int) - EVEN for x, y in places)
    found = peaks((EVEN + light).astype(np.uint8))
    assert len(places) > FEW_CANDIDATES
    assert sorted(each.peak for each in found) == places


def test_a_look_at_all_circles_spares_none_that_is_on_a_flank() -> None:
    """Circles that reach everywhere have each blob looked at."""
    random = np.random.default_rng(4)
    table = np.zeros((60, FIELDS + 1))
    table[:, :2] = random.uniform(0.0, 400.0, (60, 2))
    table[:, 2:6] = random.uniform(0.7, 6.0, (60, 4))
    table[:, 6], table[:, 11] = random.uniform(-0.9, 0.9, 60), random.uniform(20.0, 200.0, 60)
    circles = np.array([table[:, 0], table[:, 1], table[:, 2]**2 + table[:, 3]**2])
    wide = circles + [[0.0], [0.0], [1e9]]
    on_flank, near = 0, np.empty(60, np.int64)
    for x, y in random.integers(0, 400, (1000, 2)).tolist():
        narrowest = _on_flank(table, circles, 60, x, y, 5.0, near)
        assert narrowest == _on_flank(table, wide, 60, x, y, 5.0, near)
        on_flank += narrowest > 0.0
    assert 100 < on_flank < 900


def test_what_hides_behind_the_mask_is_left_out() -> None:
    """The pixel of the peak decides."""
    mask = np.ones(SHAPE, np.uint8)
    lit = lit_by(60.0, 40.0, 2.0, 100.0)
    mask[40, 61] = 0
    assert len(peaks(lit, mask=mask)) == 1
    mask[40, 60] = 0
    assert peaks(lit, mask=mask) == []


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
def test_a_fall_is_no_peak_in_either_depth(kind: type) -> None:
    """Unsigned pixels do not wrap around."""
    lit = lit_by(60.0, 40.0, 2.0, 100.0, kind=kind)
    assert peaks(EVEN.astype(kind), lit) == []
    assert len(peaks(lit, EVEN.astype(kind))) == 1


def test_full_scale_of_sixteen_bits_does_not_overflow() -> None:
    """A rise from 0 to 65535 DN."""
    lit = np.zeros(SHAPE, np.uint16)
    lit[45:52, 60:67] = 65535
    found, = peaks(lit, np.zeros(SHAPE, np.uint16), saturation=65535)
    assert found.height == 65535.0
    assert (found.x, found.y) == pytest.approx((63.0, 48.0), abs=0.05)


def test_a_row_that_brightened_is_no_peak() -> None:
    """All of it did, and a blob on it still is one."""
    lit = lit_by(60.0, 40.0, 2.0, 100.0)
    lit[30:50] += 20
    near = [each for each in peaks(lit) if each.height > 60.0]
    assert len(near) == 1 and near[0].peak == (60, 40)


def test_a_single_frame_has_its_own_level_and_no_fall() -> None:
    """Nothing was subtracted: what is darker is the scene."""
    nothing = np.zeros_like(EVEN)
    lit = lit_by(60.0, 40.0, 2.0, 100.0)
    lit[36:44, 68:72] = 5
    found = peaks(lit, nothing, alone=True)[0]
    assert found.peak == (60, 40)
    assert found.fall == 0.0
    # The dark part takes a DN or two of the rows' means.
    assert found.height == pytest.approx(98.0, abs=3.0)
