"""How much wider intervals have to be for drives of other code: factors, from the worst group.

    python -m studies.widening --drives 60 --seed 3 --write

Groups are the mechanisms of ``studies.mechanisms``, one alone, none or all, at strength 1. For each
output and number of motions that tell a drive the factor is the least, from 1 on, with which the
half widths of 95 % intervals hold so large a share of the truths (``--share``) in every group. It
is stated with the networks (``shipped/widening.json``); tables of coverage are of other drives.
"""

import argparse
import json
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.answers.assessment import Assessment
from breaker.drive.answers.evidence import Given
from breaker.drive.family.level_network import EVENTS
from breaker.drive.family.network_files import open_network
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.quantities.size import Size
from breaker.shipped import DEFAULTS, model_file
from studies.mechanisms import MECHANISMS, OPTIONS, drawn, records_of

FAMILY = "medium_voltage"
FILE = Path("src/breaker/shipped/widening.json")


def ratios_of(name: str, options: argparse.Namespace, config: Mapping, levels) -> Mapping:
    """Distances of truths from medians, in half widths, by number of motions and output."""
    prior, found = Prior.from_settings(config["prior"]), defaultdict(list)
    form, own = config["endurance"]["format"], config | {"seed": options.seed}
    assessment = Assessment(own, given=Given(Size()), families=lambda: [levels])
    for number in range(options.drives):
        rng = generator(options.seed, "mechanisms", name, number)
        drive, curves = drawn(name, prior, rng)
        records, _ = records_of(curves, number, rng, options, form)
        for motions in (*MOTIONS, "both"):
            some = [each for each in records if motions in ("both", each.motion)]
            answers = assessment.infer(some)
            for k, answer in enumerate(each for each in answers if each.draws is not None):
                curve, motion = curves[answer.record.motion], answer.record.motion
                told = {
                    f"release {motion}": (answer.draws.release[motion], -curve.tenth),
                    f"switching {motion}": (
                        answer.draws.switching[motion],
                        curve.switching - curve.tenth,
                    ),
                }
                if k == 0 or len(answer.motions) == 1:
                    told |= {
                        n: (np.log(answer.inferred(n)), np.log(float(drive[n][0]))) for n in NAMES
                    }
                for output, (draws, truth) in told.items():
                    low, middle, high = np.quantile(draws, [0.025, 0.5, 0.975])
                    half = high - middle if truth > middle else middle - low
                    found[len(answer.motions), output].append(abs(truth - middle) / half)
    return found


def main(arguments: Iterable[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=60)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--share", type=float, default=0.9)
    parser.add_argument("--groups", nargs="+", choices=MECHANISMS, default=[*MECHANISMS])
    parser.add_argument("--write", action="store_true", help=f"into {FILE}")
    options = parser.parse_args(arguments)
    for key in ("length", "lead", "rate", "quantum"):
        setattr(options, key, OPTIONS[key])
    config = load([DEFAULTS])
    levels = replace(open_network(model_file(FAMILY, "levels")), widening={})
    factors: dict[int, dict[str, float]] = {1: {}, 2: {}}
    worst: dict[tuple, str] = {}
    for name in options.groups:
        for (count, output), ratios in ratios_of(name, options, config, levels).items():
            needed = max(1.0, float(np.quantile(ratios, options.share)))
            if needed > factors[count].get(output, 1.0):
                factors[count][output], worst[count, output] = round(needed, 3), name
    for count, of in factors.items():
        for output in (*NAMES, *EVENTS):
            print(count, output, of.get(output, 1.0), worst.get((count, output), ""))
    if options.write:
        known = json.loads(FILE.read_text(encoding="utf-8"))
        known[FAMILY] = {str(count): of for count, of in factors.items()}
        FILE.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
