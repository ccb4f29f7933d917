"""Transforms against SciPy's rotations."""

from __future__ import annotations

from blob_tracker.transforms import Transform, TransformError
from blob_tracker.transforms.transform import checked, interpolated, inverse, product
import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp


def drawn(random: np.random.Generator, size: float = 1.0) -> Transform:
    """Return any transform, turned by up to so much of the circle."""
    turn = Rotation.from_rotvec(size * random.uniform(-1.8, 1.8, 3))
    return Transform(tuple(random.normal(size=3)), tuple(turn.as_quat()))


def rotation(transform: Transform) -> Rotation:
    """Return its rotation."""
    return Rotation.from_quat(transform.rotation)


def test_products_and_inverses_are_those_of_matrices() -> None:
    """To rounding, of 50 pairs."""
    random = np.random.default_rng(1)
    for _ in range(50):
        outer, inner = drawn(random), drawn(random)
        both = product(outer, inner)
        point = random.normal(size=3)
        inside = inner.matrix @ point + inner.translation
        np.testing.assert_allclose(
            both.matrix @ point + both.translation,
            outer.matrix @ inside + outer.translation, atol=1e-13,
        )
        np.testing.assert_allclose(outer.matrix, rotation(outer).as_matrix(), atol=1e-14)
        nothing = product(inverse(outer), outer)
        np.testing.assert_allclose(nothing.translation, 0.0, atol=1e-14)
        np.testing.assert_allclose(nothing.matrix, np.eye(3), atol=1e-14)


@pytest.mark.parametrize('size', [1.0, 1e-3, 1e-7, 1e-10, 0.0])
def test_between_two_instants_it_is_scipys_slerp(size: float) -> None:
    """For turns of any size, and for either sign of the quaternion."""
    random = np.random.default_rng(2)
    for sign in (1.0, -1.0):
        before = drawn(random)
        step = Rotation.from_rotvec(size * random.uniform(-1.7, 1.7, 3))
        after = Transform(
            tuple(random.normal(size=3)),
            tuple(sign * (step * rotation(before)).as_quat()),
        )
        slerp = Slerp([0.0, 1.0], Rotation.concatenate([rotation(before), rotation(after)]))
        for part in (0.0, 0.25, 0.9, 1.0):
            found = interpolated(before, after, part)
            off = (slerp(part).inv() * rotation(found)).magnitude()
            assert off < 1e-12
            np.testing.assert_allclose(
                found.translation,
                (1.0 - part) * np.array(before.translation) + part * np.array(after.translation),
            )


def test_a_quaternion_in_six_digits_is_normalised() -> None:
    """As static_transform_publisher is given it."""
    found = checked(Transform((0.0, 0.0, 0.0), (-0.500001, 0.5, -0.5, 0.499999)))
    assert np.linalg.norm(found.rotation) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize('transform, words', [
    (Transform((np.nan, 0.0, 0.0)), 'must be finite'),
    (Transform((0.0, np.inf, 0.0)), 'must be finite'),
    (Transform(rotation=(0.0, 0.0, 0.0, 0.0)), 'has the length 0; it must have the length 1'),
    (Transform(rotation=(0.0, 0.0, 0.0, 1.01)), 'has the length 1.01'),
    (Transform(rotation=(0.0, np.nan, 0.0, 1.0)), 'must be finite'),
])
def test_what_is_no_transform_is_refused(transform: Transform, words: str) -> None:
    """With the numbers."""
    with pytest.raises(TransformError, match=words):
        checked(transform)
