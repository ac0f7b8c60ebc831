"""The audit of a preset: whether its ledger closes and whether it converges at the order of its integrators."""

from gen_art.audit.findings import Audit, audit
from gen_art.audit.measure import Trend

__all__ = ["Audit", "Trend", "audit"]
