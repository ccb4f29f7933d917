"""Light -> Frame: where pictures come from."""
