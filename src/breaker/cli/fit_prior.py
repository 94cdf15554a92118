"""`breaker fit-prior`: fit the prior of a type of breaker."""

import argparse
from collections.abc import Mapping
from contextlib import suppress

from breaker.cli.inputs import add_path, limits_of, settings_of
from breaker.cli.outputs import check_outputs, draw, say_written, write_lines
from breaker.common.visible_text import say


def add(fit_prior: argparse.ArgumentParser) -> None:
    """Fit the prior of a type of breaker to records of some of its breakers: medians, and spread
    with room for wear. Prints checks of it and the lines of configuration that hold it, which
    `breaker infer --config` and the workflow take as they are.
    """
    what = "records of one breaker, or of several with a table operations.csv"
    add_path(fit_prior, "folders", "FOLDER", what, nargs="+")
    fit_prior.add_argument("--type", default="", metavar="NAME", help="as the table states it")
    add_path(fit_prior, "--output", "YAML", "write the lines there")
    add_path(fit_prior, "--plot", "PNG", "draw the prior there")


def run(options: argparse.Namespace) -> int:
    """Fit and check the prior, and print the lines of configuration that hold it."""
    outputs = [(options.output, "lines"), (options.plot, "picture")]
    check_outputs(outputs, [*options.folders, *options.config])
    config = settings_of(options.config)
    limits = limits_of(config, options.config)
    from breaker.common.terminal import text_of
    from breaker.configuration.loading import check, defaults, merge
    from breaker.diagnosis.prior_checks import check_fitted
    from breaker.diagnosis.prior_report import overlay_of, overlay_text, words_of_prior
    from breaker.diagnosis.type_prior import SWINGING, FittedPrior, swings_back
    from breaker.model.limits import from_list
    from breaker.model.parameters import Size
    from breaker.model.quantities import speeds_of

    seed = config["seed"]
    recorded, fitted = _fitted(options, config)
    usual = defaults()
    form = usual["endurance"]["format"]
    given = {k: v for k, v in config["endurance"]["format"].items() if v != form[k]}

    def overlay_with(fitted: FittedPrior) -> dict:
        return overlay_of(recorded, fitted, usual["sensor"], given)

    fitted = fitted.accepted(lambda each: check(merge(config, overlay_with(each)), curves=False))
    overlay = overlay_with(fitted)
    if "closing" in recorded.motions and swings_back(fitted.prior, recorded.size, seed) > SWINGING:
        closings = overlay | {"motions": ["closing"]}
        with suppress(ValueError):  # where limits are of openings alone
            check(merge(config, closings), curves=False)
            overlay = closings
    own = merge(config, overlay)
    speeds = speeds_of(own["speeds"], Size(**own["size"]))
    limits = [e for e in from_list(limits, recorded.motions, speeds) if e.of == "model"]
    checks = check_fitted(fitted, recorded, limits, seed)
    text = overlay_text(overlay, recorded, checks)
    written = [write_lines(options.output, text) if options.output else text.removesuffix("\n")]
    if options.plot:
        from breaker.figures.reports import fitted_prior

        written.append(draw(fitted_prior(fitted), options.plot))
    say(text_of(words_of_prior(recorded, fitted, checks)), end="\n\n")
    say_written(written)
    return 0


def _fitted(options: argparse.Namespace, config: Mapping) -> tuple:
    """The records of some breakers, and the prior fitted to them."""
    from breaker.configuration.definitions import family_of
    from breaker.diagnosis.named_records import each_once
    from breaker.diagnosis.session import Diagnosis
    from breaker.diagnosis.type_prior import fit_type, wear_allowance
    from breaker.diagnosis.type_records import list_breakers, read_breakers
    from breaker.shipped import HELD_BACK

    listed = list_breakers(each_once(options.folders), config["motions"], options.type)
    recorded = read_breakers(listed, Diagnosis(config))
    return recorded, fit_type(recorded, wear_allowance(family_of(HELD_BACK)["wear"]["change"]))
