"""Bearings over time and of several cameras -> where the target is."""
