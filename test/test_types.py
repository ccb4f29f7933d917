"""What travels between the rooms is filled at once, and is as any other frozen dataclass."""

from __future__ import annotations

from dataclasses import fields, FrozenInstanceError, MISSING, replace
from inspect import signature
import pickle

from blob_tracker.types import Bearing, Frame, Glimpse, Location, Mosaic, Window
import numpy as np
import pytest


@pytest.mark.parametrize('kind', [Frame, Window, Location, Bearing, Glimpse, Mosaic])
def test_a_class_is_made_of_its_fields(kind: type) -> None:
    """In their order, with their defaults; none of them can be set later."""
    parameters = list(signature(kind).parameters.values())
    assert [each.name for each in parameters] == [each.name for each in fields(kind)]
    for parameter, own in zip(parameters, fields(kind)):
        assert (parameter.default is parameter.empty) == (own.default is MISSING)
        assert own.default is MISSING or parameter.default == own.default


def test_a_window_is_frozen_and_can_be_replaced_and_kept() -> None:
    """Its own check is made for each that is made."""
    window = Window(np.zeros((3, 3), np.uint8), x0=4)
    with pytest.raises(FrozenInstanceError):
        window.x0 = 5  # type: ignore[misc]
    moved = replace(window, x0=5)
    assert (window.x0, moved.x0, moved.lit is window.lit) == (4, 5, True)
    assert pickle.loads(pickle.dumps(moved)).x0 == 5
    with pytest.raises(ValueError, match='sum of 0 frames'):
        replace(window, looks=0)


def test_a_frame_refuses_what_is_none() -> None:
    """By the shape that its layout has."""
    with pytest.raises(ValueError, match='non-empty'):
        Frame(np.zeros((3, 3, 3), np.uint8), 0, 255)
    with pytest.raises(ValueError, match='uint8 or uint16'):
        Frame(np.zeros((3, 3)), 0, 255)  # type: ignore[arg-type]
