"""The arms that are compared, by name.

Each is made in a process of its own: backends are chosen when they are imported. sbi's NPE-PFN is
no arm, for its pretrained weights have to be fetched from their maker.
"""

ARMS = {
    "breaker_coupling_flow": "breaker, coupling flow (the default)",
    "breaker_flow_matching": "breaker, flow matching",
    "bayesflow_default_torch": "BayesFlow, coupling flow, as shipped (torch)",
    "bayesflow_default_jax": "BayesFlow, coupling flow, as shipped (JAX)",
    "bayesflow_coupling_jax": "BayesFlow, spline coupling flow, tuned (JAX)",
    "bayesflow_matching_torch": "BayesFlow, flow matching, tuned (torch)",
    "bayesflow_matching_jax": "BayesFlow, flow matching, tuned (JAX)",
    "sbi_npe": "sbi, NPE (spline flow)",
    "sbi_fmpe": "sbi, FMPE (flow matching)",
}


def environment(arm: str) -> dict[str, str]:
    """Return the environment variables that an arm needs before its tool is imported."""
    return {"KERAS_BACKEND": arm.split("_")[-1]} if arm.startswith("bayesflow") else {}


def make(arm: str):
    """Return the arm, untrained."""
    if arm.startswith("bayesflow"):
        from studies.peers.fit_bayesflow import BayesFlow as Arm
    elif arm.startswith("sbi"):
        from studies.peers.fit_sbi import Sbi as Arm
    else:
        from studies.peers.fit_breaker import Breaker as Arm
    return Arm(arm)
