"""Location -> Bearing: from pixels to milliradians."""
