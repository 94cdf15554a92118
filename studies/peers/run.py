"""Train one arm within a budget, and score it on held-out records: one run of the comparison.

    python -m studies.peers.run --arm sbi_npe --motion closing --seed 1 --seconds 120

A short warm-up in the same process finds the number of steps that fits; the training then starts
anew, with its schedules over that number. The budget is spent on all that follows the simulation of
the bank: set-up, compilation, steps, validations. Standardised outputs throughout: log parameters
in prior sd, the onset in its own. Scores need the exact posteriors (exact.py); slow arms are scored
on fewer curves, as many as fit into so many seconds for each of the scores.
"""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from breaker.configuration.loading import defaults
from breaker.paper.calibration import calibration_p_values, family_p_value, ranks
from breaker.paper.correction import importance
from studies.peers.arms import ARMS, environment, make
from studies.peers.common import (
    CLOCKS,
    HeldOut,
    bank_of,
    classifier_accuracy,
    held_out,
    mean_and_error,
    parser,
    plan,
    restart,
    write_json,
)

_WEIGHED = 500  # draws of a curve that are weighed, and that the classifier tells from exact ones
_CALIBRATION = 100  # draws of a curve that its truth is ranked among
_CURVES = {"weights": 200, "calibration": 1000, "c2st": 50}  # at most
_CHUNK = {"weights": 10, "calibration": 50, "c2st": 1}  # made together
_FEW = 20  # curves at whose truth solvers are compared


def main() -> None:
    options = parser(__doc__.splitlines()[0], "run")
    options.add_argument("--arm", choices=ARMS, required=True)
    options.add_argument("--seconds", type=float, default=120.0, help="budget of the training")
    options.add_argument("--clock", choices=CLOCKS, default="wall", help="that the budget is of")
    options.add_argument("--exact", type=Path, required=True, help="file that exact.py made")
    options.add_argument("--cap", type=float, default=10.0, help="seconds for each of the scores")
    given = options.parse_args()
    restart(given.threads, **environment(given.arm))

    wall = CLOCKS["wall"]
    marks = [wall()]
    settings = defaults()
    data = held_out(given.motion, settings, max(_CURVES.values()))
    bank = bank_of(data.model)
    arm = make(given.arm)
    marks.append(wall())
    planned = plan(
        lambda steps: arm.train(bank, data.model, steps, given.seed), given, unit=arm.unit
    )
    marks.append(wall())
    begin = CLOCKS["processor"]()
    trained = arm.train(bank, data.model, planned["steps"], given.seed)
    processor = CLOCKS["processor"]() - begin
    marks.append(wall())
    scores = score(arm, data, given)
    marks.append(wall())
    names = ("start", "warm-up", "training", "scoring")
    seconds = dict(zip(names, np.diff(marks).tolist(), strict=True))
    asked = {key: getattr(given, key) for key in ("arm", "motion", "seed", "threads", "clock")}
    record = asked | {"budget": given.seconds, "plan": planned, "seconds": seconds}
    record |= {"processor_seconds": processor, "settings": arm.settings(), **trained, **scores}
    write_json(given.out, record)


def score(arm, data: HeldOut, given) -> dict:
    """Score a trained arm: solver, density of the truth, weights, classifier, calibration."""
    reference = json.loads(given.exact.read_text(encoding="utf-8"))
    exact = np.load(given.exact.with_suffix(".npy"))
    some = slice(reference["curves"])
    density, record = densities(arm, data, some)
    pairs = zip(data.z[some], data.measured[some], strict=True)
    joint = np.array([data.model.log_joint(z[None], measured)[0] for z, measured in pairs])
    true = joint - reference["log_evidence"]
    record |= {"exact_log_density": mean_and_error(true), "gap": mean_and_error(true - density)}

    drawn, found = weights(arm, data, given)
    record |= found
    record |= compared(drawn, exact, given)
    return record | calibration(arm, data, given)


def densities(arm, data: HeldOut, some: slice) -> tuple[np.ndarray, dict]:
    """Choose the solver; return log densities of the truth ``(n,)`` and what to record of both."""
    few = slice(_FEW)
    # All with a solver that is as good as the arm's default, and faster.
    solver = arm.choose_solver(data.measured[few], data.z[few, None])
    density = arm.log_prob(data.measured[some], data.z[some, None])[:, 0]
    record = {"solver": solver, "density_curves": len(density)}
    return density, record | {"log_density": mean_and_error(density)}


def calibration(arm, data: HeldOut, given) -> dict:
    """Say whether truths are anywhere among an arm's draws, as often."""
    parts = [
        ranks(arm.sample(data.measured[some], _CALIBRATION, given.seed), data.z[some])
        for some in capped("calibration", given.cap)
    ]
    p_values = calibration_p_values(np.concatenate(parts), _CALIBRATION)
    counted = sum(len(part) for part in parts)
    return {"calibration_curves": counted, "calibration_p": family_p_value(p_values)}


def capped(of: str, seconds: float) -> Iterator[slice]:
    """Give slices of curves, one after the other, until the time is over; at least one."""
    clock = CLOCKS["wall"]
    begin, most, step = clock(), _CURVES[of], _CHUNK[of]
    for start in range(0, most, step):
        yield slice(start, min(start + step, most))
        if clock() - begin > seconds:
            return


def weights(arm, data: HeldOut, given) -> tuple[np.ndarray, dict]:
    """Weigh draws by the exact posterior; also returns them, ``(n, d, q)``."""
    judged, found, spent = [], [], []
    for some in capped("weights", given.cap):
        measured = data.measured[some]
        z, seconds = timed(lambda m=measured, s=some: arm.sample(m, _WEIGHED, given.seed + s.start))
        found.append(z)
        spent.append(seconds / z[..., 0].size)
        for points, density, record in zip(z, arm.log_prob(measured, z), measured, strict=True):
            judged.append(importance(data.model.log_joint(points, record), density))
    sound = [one.efficiency for one in judged if not one.faulty]
    return np.concatenate(found), {
        "weighed": len(judged),
        "efficiency_quartiles": np.quantile(sound, [0.25, 0.5, 0.75]).tolist(),
        "faulty_curves": len(judged) - len(sound),
        # The median chunk, as the first compiles.
        "draws_per_second": 1.0 / float(np.median(spent)),
    }


def timed(function: Callable[[], np.ndarray]) -> tuple[np.ndarray, float]:
    """Return what a function returns, and the seconds that it took."""
    begin = CLOCKS["wall"]()
    return function(), CLOCKS["wall"]() - begin


def compared(drawn: np.ndarray, exact: np.ndarray, given) -> dict:
    """Tell an arm's draws from exact ones, curve by curve."""
    found = []
    for some in capped("c2st", given.cap):
        if some.stop > len(drawn):
            break
        pair = (each[some.start, :_WEIGHED] for each in (exact, drawn))
        found.append(classifier_accuracy(*pair, given.seed))
    return {"c2st": mean_and_error(np.array(found)), "c2st_curves": len(found)}


if __name__ == "__main__":
    main()
