"""`breaker report`: write a test report of a visit."""

import argparse
import re
from collections.abc import Mapping, Sequence
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING

from breaker.cli.named import MOTIONS, SEVERAL, add_path, each_once, is_folder
from breaker.cli.outputs import check_outputs, write_bytes, write_lines
from breaker.cli.printing import say
from breaker.cli.reference import add_reference, overlays_of
from breaker.cli.settings import limits_of, settings_of

if TYPE_CHECKING:
    from breaker.files import Preamble

_PLATE = ("station", "bay", "type", "serial")  # what a file may state of its breaker
_BESIDE = {  # and of the test, by words in its name
    "Gas pressure": r"gas.*(?:press|druck)|gasdruck|sf6.*(?:press|druck)|\bpression|presi[oó]n",
    "Temperature": r"temperat|\btemp\b",
    "Operator": r"\boperator\b|tested by|engineer|prüfer|opérateur|operador|technici",
}
# Beside those of the configuration, which may need the contact: any record shows them.
_SPEEDS = {f"{motion}_speed_10_90": ["10 % of stroke", "90 % of stroke"] for motion in MOTIONS}


def add(report: argparse.ArgumentParser) -> None:
    """Write the report of a visit to one breaker: what is measured of each channel and motion
    against limits, what poles differ by, what has changed since the visit before, what the model
    adds, and the curves. A file may hold O, C, C-O or O-C-O, and several channels, which are phases
    or poles. The status is 1 if no record could be used.
    """
    add_path(report, "files", "FILE", "a record of the visit, or a folder of them", nargs="+")
    add_path(report, "--output", "PDF|HTML", "write the report there", required=True)
    add_path(report, "--before", "FILE", "records of the visit before", **SEVERAL)
    what = "columns of travel (default: all that move)"
    report.add_argument("--channel", help=what, metavar="NAME", **SEVERAL)
    add_reference(report)


def _run(options: argparse.Namespace) -> int:
    read = [*options.files, *options.before, *filter(None, [options.reference]), *options.config]
    check_outputs([(options.output, "report")], read)
    config = settings_of(options.config)
    limits = limits_of(config, options.config)
    # Imported here, so that --help and wrong options answer at once.
    from breaker.answers import Given, infer_drive, judged, report_of
    from breaker.cli.infer import families
    from breaker.mechanism import from_list

    form, endurance = config["endurance"]["format"], config["endurance"]
    records = _read(options.files, options, form)
    if all(each.reason for each in records):
        reasons = "\n  ".join(each.reason for each in records)
        raise ValueError(f"no record can be used; breaker inspect FILE says how:\n  {reasons}")
    good = _read([options.reference], options, form) if options.reference else []
    overlays = overlays_of(records, good, options)
    _check_one(records)
    stated = {each.operation.file: each.stated for each in records}
    settings = {name: endurance[name] for name in ("draws", "misfit_p_value")}
    settings["seed"] = config["seed"]
    config["speeds"] = points = _points(stated, config)
    answers = infer_drive(records, families(None), Given(), points, settings)
    speeds = next(each.speeds for each in answers if each.speeds)
    limits = from_list(
        limits, [m for m in MOTIONS if any(m == each.motion for each in records)], speeds
    )
    beside = {
        "plate": _plate(records, stated),
        "printed": _printed(stated, records, points),
        "overlays": overlays,
        "changes": _changes(records, options, config),
        "rejected": [each.reason for each in good if each.reason],
    }
    verdicts = [judged(each, limits, seed=config["seed"]) for each in answers]
    found = report_of(answers, verdicts, beside)
    lacking = _write(found, options.output)
    for each in found.warnings:
        say(each)
    for reason in dict.fromkeys(each.reason for each in records if each.reason):
        say(f"breaker: not in the report: {reason}", beside=True)
    say(f"{found.verdict.text}\nreport written to {options.output}")
    if lacking:
        say(lacking)
    return 0


def _read(named: Sequence[str], options: argparse.Namespace, form: Mapping) -> list:
    """Records of every motion of every channel of files.

    A channel is the operation's phase. A folder's table says all of this itself.
    """
    from breaker.answers import read_operations
    from breaker.files import MANIFEST, Operation, read_manifest, record_files

    rows: dict[str, list] = {motion: [] for motion in MOTIONS}
    files: list[Path] = []
    for each in map(Path, named):
        if not is_folder(str(each)):
            files.append(each)
        elif (each / MANIFEST).exists():
            for motion, operation in read_manifest(each / MANIFEST):
                rows[motion].append(operation)
        else:
            files += record_files(each)
    if len(names := {each.breaker for some in rows.values() for each in some}) > 1:
        raise ValueError(f"a report is of one breaker, and these are {', '.join(sorted(names))}")
    whole: dict[str, list] = {motion: [] for motion in MOTIONS}
    own = str(form["travel_column"])  # of which the configuration may name contact and coil
    for number, file in enumerate(each_once(files), start=1):
        for channel, (phase, besides) in _channels(file, options.channel).items():
            for motion, each in whole.items():
                beside = besides[motion].settings if motion in besides else {}
                unset = {k: v for k, v in beside.items() if form[k] is None or channel != own}
                each.append(Operation(number, file, channel, phase=phase, settings=unset))
    return [*read_operations(rows, form), *read_operations(whole, form, loose=True)]


def _check_one(records: Sequence) -> None:
    """Refuse files that name different breakers: poles of one may have numbers, but one bay."""
    for name, beside in (("serial", "bay"), ("bay", "serial")):
        named, same = ({getattr(each.stated, of) for each in records} for of in (name, beside))
        if len(named - {""}) > 1 and (len(same) > 1 or not all(same)):
            raise ValueError(
                f"a report is of one breaker, and the files state {name} "
                f"{' and '.join(sorted(named - {''}))}; write one report of each"
            )


def _channels(file: Path, chosen: Sequence[str]) -> dict[str, tuple[str, Mapping]]:
    """Names of channels, and what goes with each, by columns of travel of a file; the name of one
    alone is empty.
    """
    from breaker.files import RejectedCurveError
    from breaker.inspection import travel_channels

    try:
        found = travel_channels(file)
    except (ValueError, RejectedCurveError):
        found = {}  # to be read as configured, or rejected with the reason
    channels = {each: found.get(each, (each, {})) for each in [*chosen] or [*found] or [""]}
    alone = len(channels) == 1
    return {key: ("" if alone else name, beside) for key, (name, beside) in channels.items()}


def _plate(records: Sequence, stated: Mapping) -> list[tuple[str, str]]:
    """Nameplate and test, as far as they are known: of the table of operations, and of files."""
    from breaker.files import printable
    from breaker.mechanism import in_digits

    operations = [each.operation for each in records]
    files = dict.fromkeys(each.operation.file for each in records if not each.reason)
    first, *more = (printable(file).rpartition("/")[2] for file in files)
    shown = [
        f"{in_digits(each.temperature, 4)} °C" if each.temperature == each.temperature else ""
        for each in operations
    ]
    beside = {name: [_beside(each, name) for each in stated.values()] for name in _BESIDE}
    serials = [each.serial for each in stated.values()]
    known = {
        "Breaker": [each.breaker for each in operations if each.breaker] or serials,
        "Test date": [
            each.date or " or ".join(dict.fromkeys(stated[each.file].dates)) for each in operations
        ],
        "Files": [first + (f" and {len(more)} more" if more else "")],
        **{name.title(): [getattr(each, name) for each in stated.values()] for name in _PLATE},
        "Linkage ratio": [
            in_digits(each.ratio, 6) for each in stated.values() if each.ratio == each.ratio
        ],
        **(beside | ({"Temperature": shown} if any(shown) else {})),
        "Channels": [each.phase for each in operations],
        "Contacts": [str(each.settings.get("contact_column") or "") for each in operations],
        "Motions": [each.motion for each in records],
    }
    pairs = [(name, ", ".join(filter(None, dict.fromkeys(each)))) for name, each in known.items()]
    always = "Breaker", "Test date"
    return [(name, text or "not stated") for name, text in pairs if text or name in always]


def _beside(stated: "Preamble", name: str) -> str:
    """What a file states of a test by the words of its name, with its unit; nothing if it does
    not.
    """
    found = (each for each in stated.pairs if re.search(_BESIDE[name], each.name.lower()))
    return next((f"{each.text} {each.unit}".rstrip() for each in found if each.text), "")


def _points(stated: Mapping, config: Mapping) -> dict:
    """Points of speeds: of the configuration, or else those of the speeds that files print."""
    from breaker.inspection import stated_speeds

    points = _SPEEDS | config["speeds"]
    for motion in MOTIONS:
        speeds = (stated_speeds(each).get(motion) for each in stated.values())
        own = {tuple(each.points) for each in speeds if each}
        if points.get(f"{motion}_speed") is None and len(own) == 1:
            points[f"{motion}_speed"] = own.pop()
    return points


def _printed(stated: Mapping, records: Sequence, points: Mapping) -> dict:
    """What the analyser printed, by file, motion, channel and quantity: the value, what differs
    in its definition, and what the analyser means by it.

    A channel is meant by its phase, or else by its number among those of the file.
    """
    from breaker.files import channel_of, phase_in, printable
    from breaker.inspection import meant_motions, measured_name, stated_speeds

    found = {}
    for file, preamble in stated.items():
        own = [each for each in records if each.operation.file == file]
        phases = list(dict.fromkeys(each.operation.phase for each in own))
        speeds = {m: tuple(each.points) for m, each in stated_speeds(preamble).items()}
        for each in preamble.results:
            place = channel_of(each.channel) - 1
            phase = phase_in(each.channel) or each.channel
            if phase not in phases and 0 <= place < len(phases):
                phase = phases[place]
            for motion in meant_motions(each, (record.motion for record in own)):
                name = measured_name(each, motion)
                odd = each.quantity == "speed" and speeds.get(motion) != tuple(
                    points.get(name) or ()
                )
                if name and not isnan(each.size):
                    value = each.value * each.size, "other points" * odd, each.quantity
                    found.setdefault((printable(file), motion, phase, name), value)
    return found


def _changes(records: Sequence, options: argparse.Namespace, config: Mapping) -> dict:
    """The comparison with the visit before, by channel."""
    if not options.before:
        return {}
    from breaker.answers import compared, swapped

    before = _read(options.before, options, config["endurance"]["format"])
    rejected = [each.reason for each in before if each.reason]
    found, said = {}, swapped(before, records)
    for phase in dict.fromkeys(each.operation.phase for each in records):
        pair = {"before": before, "today": records}
        visits = {v: [e for e in rows if e.operation.phase == phase] for v, rows in pair.items()}
        if not visits["before"]:
            said = [*rejected, f"the visit before has no channel {phase}".rstrip()]
            found[phase] = {"changes": [], "trust": said}
            continue
        try:
            found[phase] = compared(visits, config)
            found[phase]["warnings"] += [f"WARNING: {said}"] if said else []
        except ValueError as error:
            found[phase] = {"changes": [], "trust": [*rejected, str(error).splitlines()[0]]}
    return found


def _write(report, output: str) -> str:
    """Write a report as its name's ending says, and return what to say of its letters.

    All of it is drawn before a file is begun.
    """
    from breaker.figures import report as drawn
    from breaker.figures.paper import encoded, without_font

    if output.lower().endswith(".pdf"):
        pages = list(drawn.pages(report))
        write_bytes(output, encoded(pages, "pdf"))
        return without_font(pages)
    from breaker.answers import report_page

    pages = list(drawn.curve_pages(report))
    write_lines(output, report_page(report, [encoded([each], "png") for each in pages]))
    return without_font(pages)
