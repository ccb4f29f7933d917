"""The virtual lab: light, optics and sensor, with the truth kept."""
