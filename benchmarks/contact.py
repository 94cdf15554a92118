"""What the time of touch or parting adds to a record: widths and coverage on redrawn rigs.

Drives of the family of rigs, which the model does not fit, other ones than its error is learned
from: each is recorded once per motion with the default sensor, and its contact with an error of
``SD``. Their exact posteriors, without and with the contact's time, are compared: the median of the
posterior sd, and the share of rigs whose own value is in the 90 % interval.

    python benchmarks/contact.py [results/discrepancy.zarr] [rigs]
"""

import os
import sys

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np

from breaker.mechanism import NAMES, evaluate
from breaker.model import Contact, Model, generator, open_discrepancy
from breaker.posterior import approximate, correct
from breaker.shipped import DEFAULTS
from breaker.synthetic import Family
from breaker.workflow import load

SEED, SD, DRAWS = 71, 0.1, 500
TIMES = {"closing": "touch_time", "opening": "part_time"}
SHOWN = ("mu", "k_b", "gamma_b", "L")


def posterior(model, record, truth, settings, rng):
    """Posterior sds, whether 90 % intervals hold the truth, and whether the record resolved."""
    start = approximate(model, record, DRAWS, rng)
    found = correct(model, record, start, settings, rng)
    theta = found.draws[:, : len(NAMES)]
    times = evaluate([TIMES[model.motion]], theta, model.motion)
    lower, upper = np.nanquantile(np.hstack([theta, times]), [0.05, 0.95], axis=0)
    sd = np.append(100 * np.log(theta).std(axis=0), np.nanstd(times))
    return sd, (lower <= truth) & (truth <= upper), found.resolved


def compare(motion, store, rigs, config):
    """Rows of the table of one motion."""
    model = Model.from_settings({**config, "motion": motion}, open_discrepancy(store, motion))
    family, sensor = Family(model.prior, config["rigs"]), model.sensor
    rows = []
    for number in range(rigs):
        rng = generator(SEED, "contact", motion, number)
        drive, onset = family.new(rng), sensor.onset_sd * rng.standard_normal()
        curve, switching = drive.operate(motion, sensor.times - onset)
        record = sensor.noise_and_zero.corrupt(curve, rng)
        contact = Contact(float(switching + onset + SD * rng.standard_normal()), SD)
        theta = np.array(drive.theta)
        truth = np.append(theta, evaluate([TIMES[motion]], theta[None], motion)[0])
        models = model, model.knowing(contact=contact)
        rows.append([posterior(m, record, truth, config["correction"], rng) for m in models])
    sds, inside, resolved = (np.array([[one[i] for one in row] for row in rows]) for i in range(3))
    for column, name in enumerate((*NAMES, TIMES[motion])):
        if name in (*SHOWN, TIMES[motion]):
            unit = "ms" if name == TIMES[motion] else "%"
            before, after = np.median(sds, axis=0)[:, column]
            shares = " | ".join(f"{share:.1%}" for share in inside.mean(axis=0)[:, column])
            yield f"| {motion} | {name} | {before:.3g} {unit} | {after:.3g} {unit} | {shares} |"
    yield f"{motion}: {resolved.mean():.1%} of the posteriors resolved"


if __name__ == "__main__":
    store = sys.argv[1] if len(sys.argv) > 1 else "results/discrepancy.zarr"
    rigs = int(sys.argv[2]) if len(sys.argv) > 2 else 600
    print("| motion | quantity | sd without | sd with | inside without | inside with |")
    for motion in TIMES:
        for line in compare(motion, store, rigs, load([DEFAULTS])):
            print(line, flush=True)
