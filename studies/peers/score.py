"""Score one trained tool on held-out records: density, calibration, weights, speed.

    python -m studies.peers.score --tool sbi_npe --motion closing --model DIR

Standardised outputs throughout: log parameters in prior sd, the onset in its own. The gap in nats
needs the evidence of the records (evidence.py).
"""

import json
from pathlib import Path

import numpy as np

from breaker.posterior import importance
from breaker.validation import calibration_p_values, coverage, family_p_value, ranks
from studies.peers.common import (
    RESULTS,
    HeldOut,
    clock,
    held_out,
    mean_and_error,
    one_core,
    parser,
    read_settings,
    write_json,
)
from studies.peers.tools import TOOLS, environment, make

_CHUNK = 10  # curves whose draws are made and weighed together
_FEW = 100  # curves at whose truth solvers are compared
_GOOD = 0.2  # efficiency from which, with k below 0.7, weights are good: 400 of 2000 draws
_CALLS = 8  # of the network, for the comparison at equal calls


def main() -> None:
    options = parser(__doc__.splitlines()[0])
    options.add_argument("--tool", choices=TOOLS, required=True)
    options.add_argument("--model", type=Path, help=f"folder ({RESULTS}/MOTION/TOOL)")
    options.add_argument("--evidence", type=Path, help=f"({RESULTS}/MOTION/evidence.json)")
    options.add_argument("--curves", type=int, default=200, help="for density and weights")
    options.add_argument("--calibration", type=int, nargs=2, default=(500, 100), metavar="N")
    options.add_argument("--draws", type=int, default=500, help="weighed, a curve")
    options.add_argument("--cap", type=float, default=600.0, help="processor seconds for weights")
    options.add_argument("--rate-seconds", type=float, default=60.0, help="for each of the rates")
    given = options.parse_args()
    one_core(given.core, **environment(given.tool))

    folder = given.model or RESULTS / given.motion / given.tool
    curves, draws = given.calibration
    data = held_out(given.motion, read_settings(), max(curves, given.curves))
    tool = make(given.tool)
    tool.load(folder, data.measured.shape[1], data.z.shape[1])

    record = {"tool": given.tool, "motion": given.motion}
    record |= rates(tool, data, given.rate_seconds)
    some = slice(given.curves)
    density = tool.log_prob(data.measured[some], data.z[some, None])[:, 0]
    evidence = given.evidence or RESULTS / given.motion / "evidence.json"
    record |= against_exact(density, data, evidence)
    # All above with the tool's defaults; many draws and densities as fast as is as accurate.
    few = slice(_FEW)
    record["solver"] = tool.choose_solver(data.measured[few], data.z[few, None])
    found = tool.sample(data.measured[:curves], draws, given.seed)
    record |= calibration(found, data.z[:curves])
    record |= weights(tool, data, given)
    write_json(folder / "score.json", record)
    print(json.dumps(record, indent=1, default=float))


def against_exact(density: np.ndarray, data: HeldOut, evidence: Path) -> dict:
    """Score the log density of the truth, ``(n,)``, and its distance from the exact posterior's."""
    n = len(density)
    reference = json.loads(evidence.read_text(encoding="utf-8"))
    if reference["curves"] < n:
        raise ValueError(f"{evidence} has {reference['curves']} curves; {n} are to be scored")
    pairs = zip(data.z[:n], data.measured[:n], strict=True)
    joint = np.array([data.model.log_joint(z[None], measured)[0] for z, measured in pairs])
    exact = joint - reference["log_evidence"][:n]
    return {
        "curves": n,
        "log_density": mean_and_error(density),
        "exact_log_density": mean_and_error(exact),
        "gap": mean_and_error(exact - density),
        "gap_error_of_evidence": float(np.sqrt(np.square(reference["error"][:n]).sum()) / n),
    }


def calibration(draws: np.ndarray, z: np.ndarray) -> dict:
    """Judge draws ``(n, d, q)`` of truths ``(n, q)``; p-values are exact for discrete ranks."""
    rank, d = ranks(draws, z), draws.shape[1]
    p_values = calibration_p_values(rank, d)
    return {
        "calibration": draws.shape[:2],
        "calibration_p": p_values.tolist(),
        "calibration_family_p": family_p_value(p_values),
        "coverage_95": coverage(rank, d, levels=0.95).observed[0].tolist(),
        "contraction": (1.0 - draws.var(axis=1, ddof=1).mean(axis=0)).tolist(),
    }


def weights(tool, data: HeldOut, given) -> dict:
    """Weigh draws by the exact posterior, of as many curves as the cap of time allows."""
    begin, judged, outside = clock(), [], 0
    for start in range(0, given.curves, _CHUNK):
        some = slice(start, min(start + _CHUNK, given.curves))
        z = tool.sample(data.measured[some], given.draws, given.seed + start)
        log_q = tool.log_prob(data.measured[some], z)
        for points, density, measured in zip(z, log_q, data.measured[some], strict=True):
            joint = data.model.log_joint(points, measured)
            outside += int(np.isneginf(joint).sum())
            judged.append(importance(joint, density))
        if clock() - begin > given.cap:
            break
    sound = [one for one in judged if not one.faulty]
    efficiency, k = [one.efficiency for one in sound], [one.pareto_k for one in sound]
    return {
        "weighed": [len(judged), given.draws],
        "weighing_seconds": clock() - begin,
        "efficiency_quartiles": np.quantile(efficiency, [0.25, 0.5, 0.75]).tolist(),
        "efficiency_mean": mean_and_error(efficiency),
        "good": float(np.mean((np.array(k) < 0.7) & (np.array(efficiency) >= _GOOD))),
        "faulty_curves": len(judged) - len(sound),
        "outside_support": outside / (len(judged) * given.draws),
    }


def rates(tool, data: HeldOut, seconds: float) -> dict:
    """Measure draws per processor second, 1000 draws a curve, all curves of a call together.

    The number of curves grows until a call takes long enough; it is then made once more, so that
    a tool that keeps what it has compiled gains from it.
    """

    def timed(sample, curves: int) -> float:
        begin = clock()
        sample(np.tile(data.measured, (4, 1))[:curves], 1000)
        return clock() - begin

    def rate(sample) -> float | None:
        curves = 1
        try:
            while timed(sample, curves) < seconds / 8 and curves < 256:
                curves *= 4
            return 1000 * curves / timed(sample, curves)
        except NotImplementedError:
            return None

    tool.sample(data.measured[:1], 10, 0)  # loads and compiles what is left to
    return {
        "draws_per_second": rate(lambda measured, draws: tool.sample(measured, draws, 0)),
        f"draws_per_second_{_CALLS}_calls": rate(
            lambda measured, draws: tool.sample_with_calls(measured, draws, _CALLS)
        ),
    }


if __name__ == "__main__":
    main()
