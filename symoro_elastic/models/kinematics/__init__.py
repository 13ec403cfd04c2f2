"""Models of frames: placements, velocities, and their inverses."""
