"""Track a flashing light to a fraction of a pixel and give its angle, with a true covariance."""
