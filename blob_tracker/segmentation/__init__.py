"""Frame ... -> Window: find the flash, and cut out the pixels that hold it."""
