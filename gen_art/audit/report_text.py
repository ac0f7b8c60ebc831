"""The text of an audit's report."""

__all__ = ["write"]


def write(report) -> str:
    """An Audit as text."""
    lines = [_title(report), *_thinned(report), "", *_ledger(report), "", *_trends(report), "", *_invariants(report)]
    lines += [f"\nwarning: {sentence}" for sentence in report.warnings]
    if report.problems:
        lines += ["", *(f"NOT CLOSED: {sentence}" for sentence in report.problems)]
    else:
        lines += ["", "Everything closes."]
    return "\n".join(lines)


def _title(report) -> str:
    after = f" after a preroll of {report.preroll:g} s" if report.preroll else ""
    schemes = ", ".join(f"{name} {used}" for name, used in report.integrators.items())
    return (
        f"{report.name}, seed {report.seed}, float64: {report.film_time:g} s of film{after}, {report.simulated:.6g} s "
        f"simulated, {report.steps:,} steps of dt = {report.dt:.6g} s\n{schemes}"
    )


def _thinned(report) -> list[str]:
    if not report.changes:
        return ["with all particles of the preset"]
    shown = lambda v: f"{v:g}" if isinstance(v, (int, float)) else str(v)  # noqa: E731
    changes = [
        f"  {path} = {shown(after)} (the preset: {shown(before)})" for path, (before, after) in report.changes.items()
    ]
    return ["thinned to few particles with the same forces; bodies that attract each other are fewer too:", *changes]


def _ledger(report) -> list[str]:
    ledger = report.ledger
    lines = [
        f"ledger at dt, from {report.start.count:,} particles to {report.end.count:,} (J, N s in the preset's units)"
    ]
    for label, transfers in (("born", ledger.born), ("died", ledger.died)):
        for name, transfer in transfers.items():
            amounts = f"{transfer.count:8,}  mass {transfer.mass:.6g}  energy {transfer.energy:.6g}"
            lines.append(f"  {label:11}{name:28} {amounts}")
    for label, entries in (("work", ledger.work), ("dissipated", ledger.dissipated)):
        lines += [f"  {label:11}{name:28} {amount:14.6g}" for name, amount in entries.items() if amount]
    lines += [f"  {'impulse':11}{name:28} {_vector(v)}" for name, v in ledger.impulse.items() if v.any()]
    lines.append(
        f"  energy {report.start.energy:.8g} + work {ledger.work.total:.6g} + born {ledger.born.total.energy:.6g} "
        f"- died {ledger.died.total.energy:.6g} - dissipated {ledger.dissipated.total:.6g}"
    )
    lines.append(
        f"  = {report.end.energy - ledger.residual:.8g}, is {report.end.energy:.8g}: residual {ledger.residual:.3g}"
    )
    lines.append(f"  momentum {_vector(report.start.momentum)} -> {_vector(report.end.momentum)}")
    return lines


def _trends(report) -> list[str]:
    lines = [f"{'relative, at':34}{'dt':>10}{'dt/2':>10}{'dt/4':>10}   order"]
    for label, trends in (("energy", report.energy), ("momentum", report.momentum)):
        for name, trend in trends.items():
            if name not in report.unborn:
                values = _row(trend) if trend else "  no mass, so there is nothing to account for"
                lines.append(f"  {f'{label} residual of {name}':32}{values}")
    for name, (trend, count) in report.positions.items():
        lines.append(f"  {f'positions of {count:,} {name}':32}{_row(trend)}")
    if report.positions:
        lines.append(
            "  (positions: median distance between the same particles at this step and at half of it, relative)"
        )
    if report.unborn:
        lines.append(f"  no particle was born by then in {', '.join(report.unborn)}: use a later --time")
    if report.float32:
        errors = ", ".join(f"{name} {error:.0e}" for name, error in report.float32.items())
        lines.append(f"  float32 adds to the energy residual at dt: {errors}")
    return lines


def _row(trend) -> str:
    values = "".join(f"{value:10.1e}" for value in trend.values).ljust(30)
    if trend.at_round_off:
        return f"{values}   at round-off: an order has no meaning"
    if trend.order is None:
        return f"{values}   {'at round-off at dt' if trend.good else 'grows from round-off'}"
    if trend.is_scatter:
        return f"{values}   by chance: kinks of the field change the last value by up to {trend.scatter:.1e}"
    return f"{values}   {trend.order:.2f} (expected {trend.expected}){'' if trend.good else '  NOT CLOSED'}"


def _invariants(report) -> list[str]:
    lines = ["should be conserved, according to the forces:"]
    for (name, quantity), trend in report.invariants.items():
        if trend is not None:
            lines.append(f"  {f'{quantity} of {name}':32}{_row(trend)}")
    if len(lines) == 1:
        lines.append("  nothing by itself")
    by_reason: dict[tuple[str, str], list[str]] = {}
    for (name, quantity), reason in report.booked.items():
        if name not in report.unborn:
            by_reason.setdefault((quantity, reason), []).append(name)
    if by_reason:
        lines.append("changes, and is in the ledger:")
    return lines + [f"  {quantity} of {', '.join(names)}: {reason}" for (quantity, reason), names in by_reason.items()]


def _vector(v) -> str:
    return f"({', '.join(f'{c:.4g}' for c in v)})"
