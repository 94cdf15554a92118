"""`breaker report`: a test report of a visit, to leave with the breaker."""

import argparse
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path

from breaker.cli.named import MOTIONS, add_path, each_once
from breaker.cli.outputs import check_outputs, whole, write_lines
from breaker.cli.reference import add_reference, overlays_of
from breaker.cli.settings import limits_of, settings_of

__all__ = ["add"]

_PLATE = ("station", "bay", "type", "serial")  # what a file may state of its breaker
# Beside those of the configuration, which may need the contact: any record shows them.
_SPEEDS = {f"{motion}_speed_10_90": ["10 % of stroke", "90 % of stroke"] for motion in MOTIONS}


def add(commands) -> argparse.ArgumentParser:
    report = commands.add_parser(
        "report",
        help="write a test report of a visit",
        description="Write the report of a visit to one breaker: what is measured of each channel "
        "and motion against limits, what poles differ by, what has changed since the visit before, "
        "what the model adds, and the curves. A file may hold O, C, C-O or O-C-O, and several "
        "channels, which are phases or poles. The status is 1 if no record could be used.",
    )
    report.set_defaults(run=_run)
    add_path(report, "files", "FILE", "a record of the visit, or a folder of them", nargs="+")
    add_path(report, "--output", "PDF|HTML", "write the report there", required=True)
    several = {"nargs": "+", "action": "extend", "default": []}
    add_path(report, "--before", "FILE", "records of the visit before", **several)
    report.add_argument(
        "--channel", help="columns of travel (default: all that move)", metavar="NAME", **several
    )
    add_reference(report)
    return report


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
    stated = _stated(records, form)
    settings = {name: endurance[name] for name in ("draws", "misfit_p_value")}
    settings["seed"] = config["seed"]
    points = {**_SPEEDS, **config["speeds"]}
    answers = infer_drive(records, families(None), Given(), points, settings)
    speeds = next(each.speeds for each in answers if each.speeds)
    limits = from_list(
        limits, [m for m in MOTIONS if any(m == each.motion for each in records)], speeds
    )
    beside = {
        "plate": _plate(records, stated),
        "printed": _printed(stated, records),
        "overlays": overlays,
        "changes": _changes(records, options, config),
        "rejected": [each.reason for each in good if each.reason],
    }
    verdicts = [judged(each, limits, seed=config["seed"]) for each in answers]
    found = report_of(answers, verdicts, limits, beside)
    _write(found, options.output)
    print(f"{found.verdict.text}\nreport written to {options.output}")
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
        if not (each.is_dir() and each.suffix.lower() != ".zarr"):
            files.append(each)
        elif (each / MANIFEST).exists():
            for motion, operation in read_manifest(each / MANIFEST):
                rows[motion].append(operation)
        else:
            files += record_files(each)
    if len(names := {each.breaker for some in rows.values() for each in some}) > 1:
        raise ValueError(f"a report is of one breaker, and these are {', '.join(sorted(names))}")
    whole: dict[str, list] = {motion: [] for motion in MOTIONS}
    for number, file in enumerate(each_once(files), start=1):
        for channel, (phase, beside) in _channels(file, options.channel).items():
            for motion, each in whole.items():
                unset = {k: v for k, v in beside.get(motion, {}).items() if form[k] is None}
                each.append(Operation(number, file, channel, phase=phase, settings=unset))
    return [*read_operations(rows, form), *read_operations(whole, form, loose=True)]


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

    operations = [each.operation for each in records]
    names = [
        printable(file).rpartition("/")[2]
        for file in dict.fromkeys(each.operation.file for each in records if not each.reason)
    ]
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    warm = [
        f"{each.temperature:g} °C" for each in operations if each.temperature == each.temperature
    ]
    dates = {file: " or ".join(dict.fromkeys(each.dates)) for file, each in stated.items()}
    known = {
        "Breaker": [each.breaker for each in operations],
        "Test date": [each.date or dates[each.file] for each in operations],
        "Files": [names[0] + more],
        **{name.title(): [getattr(each, name) for each in stated.values()] for name in _PLATE},
        "Temperature": warm,
        "Channels": [each.phase for each in operations],
        "Motions": [each.motion for each in records],
    }
    pairs = [(name, ", ".join(filter(None, dict.fromkeys(each)))) for name, each in known.items()]
    return [(name, text) for name, text in pairs if text or name in ("Breaker", "Test date")]


def _stated(records: Sequence, form: Mapping) -> dict:
    """What stands above the samples of each file; nothing where that cannot be read."""
    from breaker.files import Preamble, RejectedCurveError, read_preamble

    found = {}
    for file in dict.fromkeys(each.operation.file for each in records):
        try:
            found[file] = read_preamble(file, form)
        except RejectedCurveError:
            found[file] = Preamble()
    return found


def _printed(stated: Mapping, records: Sequence) -> dict:
    """Strokes and over-travels that the analyser printed, by file, motion, channel and quantity.

    A channel is meant by its phase, or else by its number among those of the file.
    """
    from breaker.files import TO_MM, channel_of, phase_in, printable, unit_of

    found = {}
    for file, preamble in stated.items():
        own = [each for each in records if each.operation.file == file]
        phases = list(dict.fromkeys(each.operation.phase for each in own))
        motions = dict.fromkeys(each.motion for each in own)
        for each in preamble.results:
            size = TO_MM.get(unit_of(each.unit or "mm") or "")
            place = channel_of(each.channel) - 1
            phase = phase_in(each.channel) or each.channel
            if phase not in phases and 0 <= place < len(phases):
                phase = phases[place]
            for motion in [each.motion] if each.motion else motions:
                name = each.quantity
                if name == "over_travel" and motion == "opening":
                    name = "rebound"
                if size and name in ("stroke", "over_travel", "rebound"):
                    key = printable(file), motion, phase, name
                    found.setdefault(key, each.value * size)
    return found


def _changes(records: Sequence, options: argparse.Namespace, config: Mapping) -> dict:
    """The comparison with the visit before, by channel."""
    if not options.before:
        return {}
    from breaker.answers import compared

    before = _read(options.before, options, config["endurance"]["format"])
    rejected = [each.reason for each in before if each.reason]
    found = {}
    for phase in dict.fromkeys(each.operation.phase for each in records):
        pair = {"before": before, "today": records}
        visits = {v: [e for e in rows if e.operation.phase == phase] for v, rows in pair.items()}
        if not visits["before"]:
            said = [*rejected, f"the visit before has no channel {phase}".rstrip()]
            found[phase] = {"changes": [], "trust": said}
            continue
        try:
            found[phase] = compared(visits, config)
        except ValueError as error:
            found[phase] = {"changes": [], "trust": [*rejected, str(error).splitlines()[0]]}
    return found


def _write(report, output: str) -> None:
    """Write a report as its name's ending says, without the time of writing."""
    from breaker.figures import report as drawn

    if output.lower().endswith(".pdf"):
        from matplotlib.backends.backend_pdf import PdfPages

        with whole(output) as part, PdfPages(part, metadata={"CreationDate": None}) as pdf:
            for page in drawn.pages(report):
                pdf.savefig(page)
        return
    from breaker.answers import report_page

    pictures = []
    for page in drawn.curve_pages(report):
        picture = BytesIO()
        page.savefig(picture, format="png")
        pictures.append(picture.getvalue())
    write_lines(output, report_page(report, pictures))
