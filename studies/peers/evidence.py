"""Log evidence of the held-out records, once for all tools.

    python -m studies.peers.evidence --motion closing

By the correction of breaker (adaptive importance sampling with a triangular map), started from the
draws of a trained model, with many draws in the last round. What proposes the draws does not bias
the estimate.
"""

from pathlib import Path

import numpy as np

from breaker.model import generator
from breaker.posterior import Posterior, correct
from studies.peers.common import RESULTS, held_out, one_core, parser, read_settings, write_json

_NETWORK = 1000  # draws of the network, that the first map is fitted to


def main() -> None:
    options = parser(__doc__.splitlines()[0])
    options.add_argument("--model", type=Path, help=f"({RESULTS}/MOTION/breaker/model.safetensors)")
    options.add_argument("--curves", type=int, default=200)
    options.add_argument("--draws", type=int, default=20_000, help="that are weighed, a record")
    options.add_argument("--out", type=Path, help=f"({RESULTS}/MOTION/evidence.json)")
    given = options.parse_args()
    one_core(given.core)

    configured = read_settings()
    settings = {**configured["correction"], "draws": given.draws}
    data = held_out(given.motion, configured, given.curves)
    posterior = Posterior.load(
        given.model or RESULTS / given.motion / "breaker" / "model.safetensors"
    )
    rng = generator(given.seed, "evidence", given.motion)
    found = []
    for measured in data.measured:
        noise = rng.standard_normal((1, _NETWORK, data.z.shape[1]))
        draws = posterior.sample(measured[None], noise)[0]
        found.append(correct(data.model, measured, draws, settings, rng))
    judged = [corrected.importance for corrected in found]
    sizes, errors = [i.size for i in judged], [i.log_evidence_se for i in judged]
    record = {
        "curves": given.curves,
        "draws": given.draws,
        "log_evidence": [i.log_evidence for i in judged],
        "error": errors,
        "size": sizes,
        "pareto_k": [i.pareto_k for i in judged],
        "unresolved": sum(not corrected.resolved for corrected in found),
    }
    write_json(given.out or RESULTS / given.motion / "evidence.json", record)
    print(
        f"effective size: least {min(sizes):.0f}, median {np.median(sizes):.0f}; "
        f"error up to {max(errors):.3f}; {record['unresolved']} of {given.curves} unresolved"
    )


if __name__ == "__main__":
    main()
