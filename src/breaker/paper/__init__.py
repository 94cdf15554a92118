"""The paper, from simulated curves to checked posteriors: amortised inference of a drive's model.

The steps in order, each with its own module and rule of the workflow:

1. ``bank``: curves simulated with parameters from the prior (Sec. 3 and 5).
2. ``training``: a summary and an inference network learn from noisy records of them (Sec. 4).
3. ``posterior``: the trained network, which draws from the posterior of any record (Sec. 2 and 4).
4. ``correction``: the exact posterior of a record, and the network's divergence from it (not in
   the paper).
5. ``validation``: checks of the posteriors of simulated records (Sec. 6, Figs. 4 to 7), with the
   uniformity of ranks in ``calibration``.

``joint_model`` defines the model that all steps share. ``inference`` applies a posterior to
simulated records and to records of an endurance test (Figs. 8 to 10). ``run_numbers`` collects the
numbers of a run that the documentation states.
"""

from collections.abc import Mapping

from breaker.common.named_functions import load


def is_exact(config: Mapping) -> bool:
    """Return whether the exact posterior of a configuration's model can be computed.

    The exact posterior needs the drive of the paper and a prior with a known density: the section
    ``prior``, or your own prior with ``log_prob``.
    """
    own = config.get("model") or {}
    if own.get("simulator"):
        return False
    return not own.get("prior") or hasattr(load(own["prior"])(), "log_prob")
