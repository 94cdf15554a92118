"""Evidence and exact draws of the held-out records, once for all arms.

    python -m studies.peers.exact --motion closing

By adaptive importance sampling with a triangular map, started about the mode of each posterior: no
network of any arm has a part in it. What proposes the draws does not bias the evidence.
"""

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.loading import defaults
from breaker.paper.correction import correct
from studies.peers.common import held_out, parser, restart, write_json
from studies.peers.mode import approximate

_START = 1000  # draws about the mode, that the first map is fitted to; as many exact ones


def main() -> None:
    options = parser(__doc__.splitlines()[0], "exact")
    options.add_argument("--curves", type=int, default=200)
    options.add_argument("--draws", type=int, default=20_000, help="that are weighed, a record")
    given = options.parse_args()
    restart(given.threads)

    configured = defaults()
    data = held_out(given.motion, configured, given.curves)
    rng = generator(given.seed, "exact", given.motion)
    found = []
    for measured in data.measured:
        start = approximate(data.model, measured, _START, rng)
        found.append(correct(data.model, measured, start, rng, result_draws=given.draws))
    judged = [corrected.importance for corrected in found]
    record = {
        "curves": given.curves,
        "log_evidence": [i.log_evidence for i in judged],
        "error": [i.log_evidence_se for i in judged],
        "least_size": min(i.size for i in judged),
        "largest_k": max(i.pareto_k for i in judged),
        "unresolved": [k for k, corrected in enumerate(found) if not corrected.resolved],
    }
    draws = np.array([data.model.standardise(corrected.draws) for corrected in found])
    given.out.parent.mkdir(parents=True, exist_ok=True)
    np.save(given.out.with_suffix(".npy"), draws)
    write_json(given.out, record)


if __name__ == "__main__":
    main()
