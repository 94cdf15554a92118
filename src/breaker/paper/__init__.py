"""The paper, from simulated curves to checked posteriors: amortised inference of a drive's model.

The story in order, each step a module and a rule of the workflow:

1. ``bank``: curves simulated with parameters from the prior (Sec. 3 and 5).
2. ``training``: a summary and an inference network learn from records made of them (Sec. 4).
3. ``posterior``: the trained network, which gives posterior draws for any record (Sec. 2 and 4).
4. ``correction``: the exact posterior of a record, which the paper does not have, and the
   network's divergence from it.
5. ``validation``: checks of the posteriors of simulated records (Sec. 6, Figs. 4 to 7), with the
   uniformity of ranks in ``calibration``.

``joint_model`` defines the model that all of them share, ``inference`` applies a posterior to
simulated records and to those of an endurance test (Figs. 8 to 10), and ``run_numbers`` collects
the numbers of a run that the documentation states.
"""

from collections.abc import Mapping

from breaker.common.named_functions import load


def is_exact(config: Mapping) -> bool:
    """Return whether the exact posterior of a configuration's model can be computed.

    That takes the drive of the paper and a prior whose density is known: the one of the section
    ``prior``, or a prior of your own with ``log_prob``.
    """
    own = config.get("model") or {}
    if own.get("simulator"):
        return False
    return not own.get("prior") or hasattr(load(own["prior"])(), "log_prob")
