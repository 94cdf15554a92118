"""`breaker fit-prior`: a prior for a type of breaker from records of some of its breakers."""

import argparse
import logging
from collections.abc import Mapping, Sequence

from breaker.cli.named import a_path, each_once
from breaker.cli.outputs import check_outputs, whole, write_lines
from breaker.cli.settings import limits_of, settings_of

__all__ = ["add"]


def add(commands) -> argparse.ArgumentParser:
    fit_prior = commands.add_parser(
        "fit-prior",
        help="fit the prior of a type of breaker",
        description="Fit the prior of a type of breaker to records of some of its breakers: "
        "medians, and spread with room for wear. Prints checks of it and the lines of "
        "configuration that hold it, which `breaker infer --config` and the workflow take as they "
        "are.",
    )
    fit_prior.set_defaults(run=_run)
    fit_prior.add_argument(
        "folders",
        type=a_path,
        metavar="FOLDER",
        nargs="+",
        help="folder of the records of one breaker, or of several with a table operations.csv",
    )
    fit_prior.add_argument("--output", type=a_path, metavar="YAML", help="write the lines there")
    fit_prior.add_argument("--plot", type=a_path, metavar="PNG", help="draw the prior there")
    return fit_prior


def _run(options: argparse.Namespace) -> int:
    outputs = [(options.output, "lines"), (options.plot, "picture")]
    check_outputs(outputs, [*options.folders, *options.config])
    config = settings_of(options.config)
    limits = limits_of(config, options.config)
    # Imported here, so that --help and wrong options answer at once.
    from breaker.mechanism import Size, from_list, speeds_of
    from breaker.model import configured_model
    from breaker.shipped import DEFAULTS
    from breaker.typical import check_fitted, overlay_of, overlay_text, report
    from breaker.workflow import merge, read

    logging.getLogger("breaker").setLevel(logging.ERROR)  # the text has the reasons
    recorded, fitted = _fitted(options.folders, config)
    usual = read(DEFAULTS)["endurance"]["format"]
    given = {k: v for k, v in config["endurance"]["format"].items() if v != usual[k]}
    overlay = overlay_of(recorded, fitted, given)
    own = merge(config, overlay)
    models = {motion: configured_model(own, motion) for motion in recorded.drive.models}
    speeds = speeds_of(own["speeds"], Size(**own["size"]))
    limits = from_list(limits, [*models], speeds, of=["model"])
    checks = check_fitted(fitted, models, recorded.records, limits, config["seed"])
    text = overlay_text(overlay, recorded, checks)
    if options.output:
        write_lines(options.output, text)
    if options.plot:
        from breaker.figures import fitted_prior

        with whole(options.plot) as part:
            fitted_prior.fitted_prior(fitted.to_dataset()).savefig(part)
    print(report(recorded, fitted, checks))
    if options.output:
        print(f"\nwritten to {options.output}")
    else:
        print(f"\nThe lines of configuration:\n\n{text}", end="")
    if options.plot:
        print(f"drawn in {options.plot}")
    return 0


def _fitted(folders: Sequence[str], config: Mapping) -> tuple:
    """The records of some breakers, and the prior fitted to them."""
    from breaker.typical import fit_type, read_breakers, room_for_wear

    recorded = read_breakers(each_once(folders), config["motions"], config["endurance"])
    reference = next(iter(recorded.drive.models.values())).prior
    room = room_for_wear(config["rigs"]["wear"]["change"], reference)
    return recorded, fit_type(recorded.drive.models, recorded.records, room, config["seed"])
