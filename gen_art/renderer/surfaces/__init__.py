"""Surfaces in the picture: colliders with a look, the ground and balls, with their light, shadows and reflections."""
