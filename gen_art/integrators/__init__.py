"""Integrators: schemes as data, and the fused kernels that run them."""

from gen_art.integrators.schemes import INTEGRATORS, Scheme, scheme

__all__ = ["INTEGRATORS", "Scheme", "scheme"]
