"""The comparison of two visits as one document of plain values, and in words.

docs/usage.md explains its keys. A number that is not known is None.
"""

from collections.abc import Iterable, Mapping, Sequence

from breaker.answers.changed import VERDICT_WORDS, Compared
from breaker.answers.documents import plainly
from breaker.answers.words import wrapped

__all__ = ["visits_document", "visits_in_words"]

_NAME = "{:<28}{:>8} {:>8}"
_ROW = "  {:<45} {:>8}  {:<15}{:>7} {:>6} {:>7}"
_UNLIKE = 0.1  # share of the stroke, beyond any wear of the family of drives
_GROUPS = {"measured": "measured", "parameter": "inferred"}  # titles, where one begins
_NOT_TOLD = {
    "withheld": "Parameters are withheld: the drive is of no family that ships",
    "beyond": "No parameter is told: no wear of a drive is as large as this change",
    "apart": "No parameter is told: closing and opening contradict each other",
}


def visits_document(
    found: Compared,
    rows: Sequence[Mapping],
    records: Mapping[str, Mapping[str, int]],
    rejected: Sequence[Mapping],
    settings: Mapping,
) -> dict:
    """Return a comparison as a document.

    Args:
        found: The comparison.
        rows: What ``measured_changes`` returns, then what ``changes`` returns.
        records: Number of records by motion and visit.
        rejected: ``file``, ``motion``, ``visit`` and ``reason`` of records that were not used.
        settings: What the comparison was made with: ``share``, ``misfit_p_value``, ``seed``.
    """
    state = "told" if found.fits else "withheld"
    state = "apart" if len(found.ratios) > 1 else state
    state = "beyond" if found.fits and not found.ratios else state
    matches = {
        motion: {
            visit: {"p_value": match.p_value, "parts": match.parts} for visit, match in by.items()
        }
        for motion, by in found.matches.items()
    }
    document = {
        "parameters": state,
        "family": found.family,
        "matches": plainly(matches),
        "agreement": {"p_value": plainly(found.agreement), "parameter": found.least},
        "settings": dict(settings),
        "records": dict(records),
        "rejected": [dict(each) for each in rejected],
        "changes": list(rows),
    }
    return {"headline": _headline(document), "trust": _trust(document), **document}


def _headline(document: Mapping) -> str:
    """What measured has changed, and which parameters have, have not, or cannot be told."""
    beyond, rows = f"beyond {100 * document['settings']['share']:g} %", document["changes"]
    sure, unsure, _ = _by_verdict(row for row in rows if row["kind"] == "measured")
    measured = f"Measured: {sure or f'no change for sure {beyond}'}"
    if unsure:
        measured += f"; perhaps {beyond}: {unsure}"
    if document["parameters"] != "told":
        return f"{measured}\n{_NOT_TOLD[document['parameters']]}"
    sure, unsure, still = _by_verdict(row for row in rows if row["kind"] != "measured")
    inferred = f"Changed: {sure}" if sure else f"No parameter changed for sure {beyond}"
    if unsure:
        inferred += f"; cannot be told: {unsure}"
    if still:
        inferred += f"; not {beyond}: {still if unsure else 'all others'}"
    return f"{measured}\n{inferred}"


def _by_verdict(rows: Iterable[Mapping]) -> list[str]:
    """Names of what has changed, and by how much; of what cannot be told; of what has not."""
    names: dict[str, list[str]] = {verdict: [] for verdict in VERDICT_WORDS}
    for row in rows:
        low, middle, high = row["change"]
        percent = f" {middle:+.2g} % ({low:+.2g} to {high:+.2g})"
        sure = row["verdict"] == VERDICT_WORDS[0]
        names[row["verdict"]].append(_label(row) + (percent if sure else ""))
    return [", ".join(each) for each in names.values()]


def _trust(document: Mapping) -> list[str]:
    """How far a comparison can be trusted, in sentences."""
    said = _unlike(document["changes"])
    odd = [
        (motion, visit, match)
        for motion, by in document["matches"].items()
        for visit, match in by.items()
        if match["p_value"] < document["settings"]["misfit_p_value"]
    ]
    family = f"the family {document['family']}"
    if document["parameters"] == "withheld":
        where = ", ".join(f"the {motion} {visit} {_place(match)}" for motion, visit, match in odd)
        said.append(
            f"WARNING: not of a drive of {family}, the nearest that ships: {where}. What is "
            "measured holds. Look at these records with breaker infer --plot; where one motion is "
            "odd, compare the other with --motion"
        )
        return said
    least = min(match["p_value"] for by in document["matches"].values() for match in by.values())
    said.append(f"drives of {family} look like both visits (least p = {least:.2g})")
    agreement = document["agreement"]
    how = f"{agreement['parameter']}, p = {agreement['p_value']:.2g}"
    if document["parameters"] == "beyond":
        said.append(
            "WARNING: the change is larger than any that the networks know. Are both visits of the "
            "same drive and phase, and are rate and ratio of both files right?"
        )
    elif document["parameters"] == "apart":
        said.append(
            f"WARNING: closing and opening contradict each other ({how}), so that something else "
            "has changed, or a record is of another drive; what each indicates is listed apart"
        )
    elif agreement["parameter"]:
        said.append(f"closing and opening agree (least in {how})")
    return said


def _place(match: Mapping) -> str:
    """How a visit does not fit, and where most."""
    known = {part: size for part, size in match["parts"].items() if size is not None}
    where = max(known, key=known.get)
    return f"(p = {match['p_value']:.1g}, most at its {where})"


def _unlike(rows: Sequence[Mapping]) -> list[str]:
    """A warning where the stroke of both visits is hardly that of one drive."""
    for row in rows:
        if row["name"] == "stroke" and abs(row["change"][1]) > 100.0 * _UNLIKE:
            return [
                f"WARNING: the stroke of {row['motion']} was {row['before']:.4g} mm and is "
                f"{row['today']:.4g} mm today; no wear of one drive does that. Are both visits of "
                "the same drive and phase, and is endurance.format right for both?"
            ]
    return []


def _label(row: Mapping) -> str:
    """Name of a changed quantity, with the motion where the name does not tell it."""
    motion = row["motion"]
    named = not motion or motion in row["name"] or row["kind"] == "time"
    return row["name"] if named else f"{row['name']} ({motion})"


def visits_in_words(document: Mapping) -> str:
    """Return a document as text for a terminal of 100 columns."""
    counts = [
        f"{motion} {each['before']} before, {each['today']} today"
        for motion, each in document["records"].items()
    ]
    said = [*document["headline"].split("\n"), *document["trust"], f"records: {'; '.join(counts)}"]
    said += [
        f"rejected: {each['visit']}: {each['file']}: {each['reason']}"
        for each in document["rejected"]
    ]
    beyond = f"P>{100 * document['settings']['share']:g} %"
    lines = [line for each in said for line in wrapped(each, "", "  ")]
    first = _NAME.format("", "before", "today")
    title = _ROW.format(first, "change", "90 % interval", "P same", beyond, "P worse")
    lines += ["", title]
    kind = ""
    for row in document["changes"]:
        if row["kind"] != kind and row["kind"] in _GROUPS:
            lines.append(_GROUPS[row["kind"]])
        kind = row["kind"]
        lines.append(_in_words(row))
    return "\n".join(lines)


def _in_words(row: Mapping) -> str:
    low, middle, high = row["change"]
    values = [f"{row[visit]:.4g}" for visit in ("before", "today") if visit in row]
    name, alone = _label(row), row["kind"] == "parameter" and row["motion"]
    name += f" ({row['unit']})" if values else "" if alone else f": {row['meaning']}"
    known = [row[key] for key in ("unchanged", "beyond", "worse")]
    return _ROW.format(
        _NAME.format(name, *values) if values else name,
        f"{middle:+.1f} %",
        f"{low:+.1f} to {high:+.1f}",
        *("" if each is None else f"{each:.2f}" for each in known),
    ).rstrip()
