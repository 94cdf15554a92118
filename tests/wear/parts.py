"""Parts of a series, to follow it in pieces."""

from dataclasses import replace


def part(series, chosen):
    """Chosen operations of a series; its events go by their numbers."""
    known = series.temperature
    return replace(
        series,
        operations=series.operations[chosen],
        records={m: each[chosen] for m, each in series.records.items()},
        outputs={m: each[chosen] for m, each in series.outputs.items()},
        temperature=None if known is None else known[chosen],
    )
