"""Rigid bodies: their shapes, their motion, and what happens where they touch."""
