"""Starts Taichi and patches it. No other package depends on Taichi's internals."""
