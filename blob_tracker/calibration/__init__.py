"""What is measured once for a camera: lens, pixel noise and line jitter, each with its sigma."""
