"""Particles of a liquid, drawn together as its surface: found, smoothed and shaded in the space of the picture."""
