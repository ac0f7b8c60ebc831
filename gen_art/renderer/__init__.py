"""Particles become light, light becomes film: camera, colour, splat, film, develop."""

__all__ = []
