"""The comparison of two visits as one document of plain values, and in words.

docs/usage.md explains its keys. A number that is not known is None.
"""

from collections.abc import Iterable, Mapping, Sequence

from breaker.common.numerals import in_digits, in_p
from breaker.common.plain_values import plainly
from breaker.documents.parts import Document, Remark, Section, Table
from breaker.drive.answers.answer_words import limit_tables, zones_in_words
from breaker.drive.answers.visit_changes import VERDICT_WORDS, VisitChanges
from breaker.drive.family.mechanisms import CHANGE_OF
from breaker.drive.family.untold import APART, BEYOND, UNLIKE, WITHHELD, as_sentence
from breaker.quantities.advice import LOOK

_NAME = "{:<28}{:>8} {:>8}"
_ROW = "  {:<45} {:>8}  {:<15}{:>7} {:>6} {:>7}"
_GROUPS = {"measured": "measured", "parameter": "inferred"}  # titles, where one begins
_WORSE = 0.5  # probability from which on a change is one to the worse
_NOT_TOLD = {
    "unlike": f"No change of the drive is told: {UNLIKE}",
    "withheld": f"Parameters are withheld: {WITHHELD}",
    "beyond": f"No parameter is told: {BEYOND}",
    "apart": f"No parameter is told: {APART}",
}


def visits_document(
    found: VisitChanges,
    told: Mapping[str, Sequence[Mapping]],
    records: Mapping[str, Mapping[str, int]],
    rejected: Sequence[Mapping],
    settings: Mapping,
) -> dict:
    """Return a comparison as a document.

    Args:
        found: The comparison.
        told: Rows of it: ``warnings``, sentences; ``differences``, what ``unlike`` returns;
            ``changes``, what ``measured_changes`` returns, then what ``changes`` returns, which is
            left out where visits were measured differently; ``mechanisms``, what
            ``mechanism_changes`` returns, the same; ``limits``, what ``judged_today`` returns.
        records: Number of records by motion and visit.
        rejected: ``file``, ``motion``, ``visit`` and ``reason`` of records that were not used.
        settings: What the comparison was made with: ``share``, ``misfit_p_value``, ``seed``.
    """
    state = "told" if found.fits else "withheld"
    state = "apart" if len(found.ratios) > 1 else state
    state = "beyond" if found.fits and not found.ratios else state
    state = "unlike" if told["differences"] else state
    rows = [row for row in told["changes"] if state != "unlike" or row["kind"] == "measured"]
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
        "differences": plainly(told["differences"]),
        "changes": rows,
        "mechanisms": [] if state == "unlike" else [*told["mechanisms"]],
        "limits": plainly(told["limits"]),
    }
    warnings = [f"WARNING: {each}" for each in told.get("warnings", ())] + _unlike(document)
    said = {"warnings": warnings, "headline": _headline(document)}
    return said | {"trust": _trust(document)} | document


def _unlike(document: Mapping) -> list[str]:
    """How the visits were measured differently."""
    if not document["differences"]:
        return []
    differ = differ_in_words(document["differences"])
    return [
        f"WARNING: {'; '.join(differ)}. {as_sentence(UNLIKE)}, or are of different drives or "
        "phases: check transducer, ratio and endurance.format of both. What follows compares the "
        "records, not the drive"
    ]


def differ_in_words(differences: Sequence[Mapping]) -> list[str]:
    """Say how visits were measured differently, what ``unlike`` returns, each in a sentence."""
    return [
        f"the {each['what']}{' of' * bool(each['motion'])} {each['motion']}".rstrip()
        + " and".join(
            f" {verb} {_text(each[visit])} {each['unit']}".rstrip()
            for verb, visit in (("was", "before"), ("is", "today"))
        )
        for each in differences
    ]


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else in_digits(value, 4)


def _headline(document: Mapping) -> str:
    """What measured has changed, and which parameters have, have not, or cannot be told.

    Parameters are told as changed only beside a measured change: networks alone raise no alarm.
    """
    beyond, rows = (
        f"beyond {in_digits(100 * document['settings']['share'], 4)} %",
        document["changes"],
    )
    if document["differences"]:
        return _NOT_TOLD[document["parameters"]]
    measured = [row for row in rows if row["kind"] == "measured"]
    sure, unsure, _ = _by_verdict(measured)
    first = f"Measured: {sure or f'no change {beyond}'}"
    if unsure:
        first += f"; cannot be told: {unsure}"
    if document["parameters"] != "told":
        return f"{first}\n{_NOT_TOLD[document['parameters']]}"
    inferred = [row for row in rows if row["kind"] != "measured"]
    sure, unsure, still = _by_verdict(inferred)
    if sure and all(row["verdict"] != VERDICT_WORDS[0] for row in measured):
        return f"{first}\nNo parameter is told: nothing measured has changed for sure {beyond}"
    second = f"Changed: {sure}" if sure else f"No parameter changed for sure {beyond}"
    if unsure:
        second += f"; cannot be told: {unsure}"
    if still:
        second += f"; not {beyond}: {still if unsure else 'all others'}"
    sure, *_ = _by_verdict(document["mechanisms"])
    third = f"\nMechanisms beside the model, of {CHANGE_OF}: {sure}" if sure else ""
    return f"{first}\n{second}{third}"


def _by_verdict(rows: Iterable[Mapping]) -> list[str]:
    """Names of what has changed, and by how much; of what cannot be told; of what has not."""
    names: dict[str, list[str]] = {verdict: [] for verdict in VERDICT_WORDS}
    for row in rows:
        low, middle, high = row["change"]
        middle, low, high = (in_digits(each, 2, sign=True) for each in (middle, low, high))
        percent = f" {middle} % ({low} to {high})"
        sure = row["verdict"] == VERDICT_WORDS[0]
        names[row["verdict"]].append(label_of(row) + (percent if sure else ""))
    return [", ".join(each) for each in names.values()]


def _trust(document: Mapping) -> list[str]:
    """How far a comparison can be trusted, in sentences."""
    said = []
    odd = [
        (motion, visit, match)
        for motion, by in document["matches"].items()
        for visit, match in by.items()
        if match["p_value"] < document["settings"]["misfit_p_value"]
    ]
    family = f"the family {document['family']}"
    if document["parameters"] == "withheld" or (odd and document["differences"]):
        where = ", ".join(f"the {motion} {visit} {_place(match)}" for motion, visit, match in odd)
        said.append(
            f"WARNING: not of a drive of {family}, the nearest that ships: {where}. What is "
            "measured holds. Look at these records with breaker infer --plot; where one motion is "
            "odd, compare the other with --motion"
        )
        return said
    least = min(match["p_value"] for by in document["matches"].values() for match in by.values())
    said.append(f"drives of {family} look like both visits (least {in_p(least)})")
    agreement = document["agreement"]
    how = f"{agreement['parameter']}, {in_p(agreement['p_value'])}"
    if document["parameters"] == "beyond":
        said.append(
            f"WARNING: {BEYOND}. Are both visits of the same drive and phase, and are rate and "
            "ratio of both files right?"
        )
    elif document["parameters"] == "apart":
        said.append(
            f"WARNING: {APART} ({how}), so that something else "
            "has changed, or a record is of another drive; what each indicates is listed apart"
        )
    elif agreement["parameter"]:
        said.append(f"closing and opening agree (least in {how})")
    return said


def _place(match: Mapping) -> str:
    """How a visit does not fit, and where most."""
    known = {part: size for part, size in match["parts"].items() if size is not None}
    where = max(known, key=known.get)
    return f"({in_p(match['p_value'])}, most at its {where})"


def label_of(row: Mapping) -> str:
    """Name of a changed quantity, with the motion where the name does not tell it."""
    motion = row["motion"]
    named = not motion or motion in row["name"] or row["kind"] == "time"
    return row["name"] if named else f"{row['name']} ({motion})"


def visits_said(document: Mapping) -> tuple[list[str], list[str]]:
    """Return what is to be said first of a comparison, and how far it can be trusted."""
    counts = [
        f"{motion} {each['before']} before, {each['today']} today"
        for motion, each in document["records"].items()
    ]
    first = [*document["warnings"], *document["headline"].split("\n")]
    dates = document.get("dates", {})
    when = [f"{visit} {each or 'not stated'}" for visit, each in dates.items()]
    said = [f"dates: {', '.join(when)}"] if any(dates.values()) else []
    said += zones_in_words((e["name"], e["zone"]) for e in document["changes"] if "zone" in e)
    return first, [*document["trust"], f"records: {'; '.join(counts)}", *said]


def worse_in(document: Mapping) -> list[str]:
    """Return names of what a comparison tells as changed to the worse, or, where neither side is
    the worse, as changed: as the headline, nothing of visits that were measured differently, and
    parameters and mechanisms only beside a measured change.
    """
    if document["differences"]:
        return []
    sure = [
        row
        for row in (*document["changes"], *document["mechanisms"])
        if row["verdict"] == VERDICT_WORDS[0] and (row["worse"] is None or row["worse"] > _WORSE)
    ]
    measured = [row["name"] for row in sure if row["kind"] == "measured"]
    beside = any(
        row["kind"] == "measured" and row["verdict"] == VERDICT_WORDS[0]
        for row in document["changes"]
    )
    if document["parameters"] != "told" or not beside:
        return measured
    return measured + [row["name"] for row in sure if row["kind"] != "measured"]


def words_of_visits(document: Mapping) -> Document:
    """Return a comparison in words."""
    said = [each for some in visits_said(document) for each in some]
    said += [
        f"rejected: {each['visit']}: {each['file']}: {each['reason']}"
        for each in document["rejected"]
    ]
    share, rows, kind = document["settings"]["share"], [], ""
    for row in document["changes"]:
        if row["kind"] != kind and row["kind"] in _GROUPS:
            rows.append(_GROUPS[row["kind"]])
        kind = row["kind"]
        rows.append(_cells(row))
    mechanisms = [row for row in document["mechanisms"] if row["verdict"] != VERDICT_WORDS[2]]
    least = in_digits(20 * share, 4)
    rows += [f"mechanisms, % of {CHANGE_OF} (P> {least} %)"] if mechanisms else []
    rows += map(_cells, mechanisms)
    beyond = f"P>{in_digits(100 * share, 4)} %"
    first = _NAME.format("", "before", "today")
    head = (first, "change", "90 % interval", "P same", beyond, "P worse")
    tables = [Table(head, rows, form=_ROW), *limit_tables(document["limits"])]
    parts = [Section(parts=tables)]
    if look := document.get("advice"):
        parts.append(Section(LOOK, [*map(Remark, look)]))
    return Document(summary=said, parts=parts)


def _cells(row: Mapping) -> list[str]:
    values = [in_digits(row[visit], 4) for visit in ("before", "today") if visit in row]
    name, alone = label_of(row), row["kind"] == "parameter" and row["motion"]
    name += f" ({row['unit']})" if values else "" if alone else f": {row['meaning']}"
    known = [row[key] for key in ("unchanged", "beyond", "worse")]
    return [
        _NAME.format(name, *values) if values else name,
        *change_words(row),
        *("" if each is None else f"{each:.2f}" for each in known),
    ]


def change_words(row: Mapping) -> tuple[str, str]:
    """A change in percent, and its 90 % interval."""
    low, middle, high = (f"{round(each, 1) + 0.0:+.1f}" for each in row["change"])  # no -0
    return f"{middle} %", f"{low} to {high}"
