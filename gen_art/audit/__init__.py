"""The audit of a preset: whether its ledger closes, whether it converges, and whether what it expects holds."""

from gen_art.audit.expectations import Check, Finding, check
from gen_art.audit.findings import Audit, audit
from gen_art.audit.measure import Trend

__all__ = ["Audit", "Check", "Finding", "Trend", "audit", "check"]
