"""The audit of a preset: does its ledger close, and does it converge as its integrators should?"""

from gen_art.audit.findings import Audit, audit
from gen_art.audit.measure import Trend

__all__ = ["Audit", "Trend", "audit"]
