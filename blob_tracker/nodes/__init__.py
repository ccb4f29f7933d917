"""Thin nodes: declare, subscribe, call, publish."""
