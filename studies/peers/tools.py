"""The tools that are compared, by name.

Each is made in a process of its own: backends are chosen when they are imported.
"""

__all__ = ["TOOLS", "environment", "make"]

TOOLS = {
    "breaker": "breaker, flow matching",
    "breaker_coupling": "breaker, coupling flow",
    "bayesflow_shipped": "BayesFlow, as shipped (torch)",
    "bayesflow_tuned": "BayesFlow, tuned (torch)",
    "bayesflow_jax": "BayesFlow, tuned (JAX)",
    "sbi_npe": "sbi, NPE (spline flow)",
    "sbi_fmpe": "sbi, FMPE (flow matching)",
}


def environment(tool: str) -> dict[str, str]:
    """Return the environment variables that a tool needs before it is imported."""
    if not tool.startswith("bayesflow"):
        return {}
    return {"KERAS_BACKEND": "jax" if tool == "bayesflow_jax" else "torch"}


def make(tool: str):
    """Return the tool, untrained."""
    if tool.startswith("bayesflow"):
        from studies.peers.fit_bayesflow import BayesFlow as Tool
    elif tool.startswith("sbi"):
        from studies.peers.fit_sbi import Sbi as Tool
    else:
        from studies.peers.fit_breaker import Breaker as Tool
    return Tool(tool)
