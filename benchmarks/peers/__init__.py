"""Other people's methods, one file a package; a package that is missing is named, not hidden."""

from __future__ import annotations

from importlib import import_module

from benchmarks.contender import Contender

PACKAGES = ('photutils', 'sep', 'trackpy', 'picasso', 'opencv')


def available() -> tuple[list[Contender], dict[str, str]]:
    """Return the peers that import, and the reason for each package that does not."""
    peers: list[Contender] = []
    missing: dict[str, str] = {}
    for package in PACKAGES:
        try:
            peers.extend(import_module(f'benchmarks.peers.{package}').PEERS)
        except ImportError as error:
            missing[package] = str(error)
    return peers, missing
