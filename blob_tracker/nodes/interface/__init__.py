"""What each node shows of itself: data alone, read by the node and by its reference."""

from importlib import import_module

from blob_tracker.ros.interface import Interface


def interface_of(node: str) -> Interface:
    """Return what a node of `NODES` shows; only its own declarations are imported."""
    interface: Interface = import_module(f'{__name__}.{node}').INTERFACE
    return interface
