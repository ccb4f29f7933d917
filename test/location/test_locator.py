"""What the last flashes tell of the next: motion and flicker."""

from blob_tracker.location import locate, Locator
from blob_tracker.location.locate import estimate
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import LocationError, Window
import numpy as np
import pytest
from support.flashes import (
    BACKGROUND, circle, evenly, fly, nees, NOISE, pairs, PEAK, pulses, SATURATION,
)


def pulsed(exposure, random):
    """Return the light of rows 30 us apart that see pulses of 0.3 ms in each 1 ms."""
    def total(periods):
        return 0.3 * np.floor(periods) + np.minimum(periods % 1.0, 0.3)

    def share(k, rows):
        if k % 2:
            return np.zeros(rows.shape)
        start = random.uniform() + 0.03 * rows
        most = 0.3 * np.floor(exposure) + min(exposure % 1.0, 0.3)
        return (total(start + exposure) - total(start)) / most

    return share


def test_a_clean_light_is_placed_as_by_locate():
    """Change not a bit, and say nothing."""
    seen = pairs(40, evenly(1.0), evenly(0.0))
    locator = Locator()
    for n in range(40):
        window = Window(seen.lit[n], seen.unlit[n], saturation=SATURATION, stamp_ns=n * 33_000_000)
        placed, alone = locator.locate(window, noise=NOISE), locate(window, noise=NOISE)
        assert (placed.x, placed.y, placed.warning) == (alone.x, alone.y, '')
        np.testing.assert_array_equal(placed.covariance, alone.covariance)


def test_what_is_learned_later_knows_the_past_of_its_flash(monkeypatch):
    """And not that flash itself, which is remembered by then."""
    seen = pairs(12, evenly(1.0), evenly(0.0))
    locator = Locator(learn=True)
    asked = []
    monkeypatch.setattr(
        'blob_tracker.location.locator.estimate',
        lambda *_, history, **options: asked.append(history()) or estimate(*_, **options),
    )
    for n in range(12):
        window = Window(seen.lit[n], seen.unlit[n], saturation=SATURATION, stamp_ns=n * 33_000_000)
        asked.clear()
        locator.locate(window, noise=NOISE)
        _, _, _, base = locator.learners['']._window
        base()
        first, later = asked
        assert later is first and (n < 3 or first.motion.place is not None)


@pytest.mark.parametrize('share', [0.05, 0.2, 0.4])
def test_motion_tells_what_is_left_of_a_light(share):
    """Place a light that is left in the unlit frame and moves 0.8 px a frame, all ways."""
    flight = fly(
        circle(240, 0.8), lambda k, rows: np.full(rows.shape, 1.0 if k % 2 == 0 else share)
    )
    # 100 places: three standard errors are 0.6.
    assert 1.4 < flight.nees < 2.6
    assert flight.said('still on in the unlit frame') > (0.7 if share == 0.05 else 0.95)
    # All directions come by, and in none is it another thing.
    assert np.abs(flight.errors.mean(axis=0)).max() < 0.008


@pytest.mark.parametrize('exposure', [0.8, 1.7])
def test_bands_of_a_dimmed_light_are_doubted(exposure):
    """Name the flicker, and hold in the covariance how far bands may move a pulse along y."""
    random = np.random.default_rng(3)
    rest = np.repeat(45.0 + random.uniform(-1.0, 1.0, (120, 2)), 2, axis=0)
    flight = fly(rest, pulsed(exposure, random))
    # By chance three quarters of 32 flashes may be alike for once.
    assert flight.said('PWM') > 0.95
    assert flight.nees < 2.8  # 20 to 50 without
    errors = flight.errors / np.sqrt([each.covariance.diagonal() for each in flight.locations])
    assert np.abs(errors).max() < 5.0
    # x is not in doubt.
    assert np.sqrt(np.mean(flight.errors[:, 0] ** 2)) < 0.04


def test_whole_periods_are_no_bands():
    """Say nothing of a light that is exposed for two whole periods."""
    random = np.random.default_rng(3)
    flight = fly(circle(120, 0.5), pulsed(2.0, random))
    assert flight.said('PWM') == 0.0


@pytest.mark.parametrize('turning', [True, False])
def test_a_faint_tail_shows_in_many_flashes(turning):
    """
    Doubt a light that has 5 % of it in a tail of 4 px, along its way or always to the right.

    No flash by itself shows it, and it moves the place by four sigmas.
    """
    random = np.random.default_rng(8)
    locator, errors, covariances = Locator(), [], []
    for k in range(240):
        angle = 8.0 * k / 25.0  # 8 px from flash to flash, round a circle of 25 px
        x, y = 60.3 + 25.0 * np.cos(angle), 60.4 + 25.0 * np.sin(angle)
        way = np.array([-np.sin(angle), np.cos(angle)]) if turning else np.array([1.0, 0.0])
        x0, y0 = round(x) - 7, round(y) - 7
        steps = 4.0 * (np.arange(8) + 0.5) / 8.0
        lit = 0.95 * pulses(15, x - x0, y - y0) + 0.05 * pulses(
            15, x - x0 + steps * way[0], y - y0 + steps * way[1]
        ).mean(axis=0)
        lit, unlit = (
            expose(PEAK * mean + BACKGROUND, NOISE, random) for mean in (lit, np.zeros(lit.shape))
        )
        window = Window(lit, unlit, x0, y0, k * 33_333_333, SATURATION)
        found = locator.locate(window, noise=NOISE)
        if k >= 80:  # once it is known
            errors.append((found.x - x, found.y - y))
            covariances.append(found.covariance)
            assert 'lopsided' in found.warning or 'tail' in found.warning
    assert np.hypot(*np.transpose(errors)).mean() > 0.05
    # 160 places: four standard errors are 0.6.
    assert nees(errors, covariances) == pytest.approx(2.0, abs=0.6)


def test_cut_rows_are_doubted_where_a_flash_does_not_show_them():
    """Keep what the last flashes were drawn by: one that shows no cut may have one, too."""
    random = np.random.default_rng(5)
    rows, columns = np.mgrid[0:13, 0:13] - 6.0
    light = 120.0 * np.exp(-(columns**2 + rows**2) / 4.5)
    share = np.clip(0.7 - rows / 8.0, 0.0, 1.0)
    locator = Locator()

    def located(k, part):
        lit, unlit = (
            expose(BACKGROUND + each * light, NOISE, random, saturation=SATURATION)
            for each in (part, 1.0 - part)
        )
        window = Window(lit, unlit, saturation=SATURATION, stamp_ns=k * 33_000_000)
        return locator.locate(window, noise=NOISE)

    for k in range(8):
        assert 'switches' in located(k, share).warning
    after = located(8, np.ones_like(share))
    assert after.warning
    # The cut draws it up by half a pixel and more.
    assert after.covariance[1, 1] > 0.2**2 > 20.0 * after.covariance[0, 0]


def test_a_narrow_light_on_a_mosaic_is_not_said_to_flicker():
    """Leave its brightness open where it falls between the samples, 2 px apart."""
    random = np.random.default_rng(6)
    sites = np.tile(np.array([[True, False], [False, False]]), (8, 8))
    rows, columns = np.mgrid[0:16, 0:16].astype(float)
    locator = Locator()
    warnings = []
    for k in range(40):
        x, y = 8.0 + random.uniform(-1.0, 1.0, 2)
        light = np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2.0 * 0.7**2))
        lit = expose(30.0 + 120.0 * sites * light, NOISE, random, saturation=SATURATION)
        unlit = expose(np.full(lit.shape, 30.0), NOISE, random, saturation=SATURATION)
        window = Window(
            lit, unlit, saturation=SATURATION, stamp_ns=k * 33_000_000, sites=sites
        )
        try:
            warnings.append(locator.locate(window, noise=NOISE).warning)
        except LocationError:
            continue
    assert len(warnings) > 10
    assert not any('flicker' in each for each in warnings)


def test_lights_are_remembered_by_name_until_forgotten():
    """Keep the flicker of one light from another, and from what comes after a new start."""
    random = np.random.default_rng(4)
    locator = Locator()

    def warning(light, peak, k):
        y, x = np.mgrid[0:11, 0:11] - 5.0
        lit = BACKGROUND + peak * np.exp(-(x**2 + y**2) / 4.5)
        lit = np.rint(lit + random.normal(size=x.shape))
        window = Window(lit, saturation=SATURATION, stamp_ns=k * 33_000_000)
        return locator.locate(window, noise=NOISE, light=light).warning

    for k in range(20):
        flickers = warning('flickers', 60.0 + 80.0 * (k % 3 == 0), k)
        assert warning('steady', 100.0, k) == ''
    assert 'flickers' in flickers
    locator.forget()
    assert warning('flickers', 100.0, 21) == ''


def test_a_refusal_is_that_of_locate():
    """Raise what `locate` raises, and go on."""
    locator = Locator()
    with pytest.raises(LocationError, match='flat'):
        locator.locate(Window(np.full((9, 9), 30.0)), noise=NOISE)


def test_other_methods_have_no_use_for_memory():
    """Take any method."""
    seen = pairs(1, evenly(1.0), evenly(0.0))
    window = Window(seen.lit[0], seen.unlit[0])
    assert Locator('centroid').locate(window, noise=NOISE).warning == ''
