"""Neural networks: summary networks, conditional densities, and their trainer.

The networks do not depend on breakers: records are rows ``(n, t)``, and inferred outputs are
standardised numbers ``(n, q)``. ``summary.build`` makes both networks of a posterior from settings:

- A summary network maps records ``(n, t)`` to features ``(n, s)``. ``freeze`` sets, once, the
  numbers that scale its input.
- An inference network is a density of ``(n, q)`` given features, with the methods ``loss``,
  ``sample`` and ``log_prob`` of ``FlowMatching``. ``solves`` is true if it uses solver steps.

``mixture`` is the density of the family's networks; ``training`` trains all networks.
"""

CLIP = 5.0
"""Largest residual as an input, so that an outlier does not dominate later dimensions."""

WIDEST = 7.0
"""Largest logarithm of a scale or width, 1100 times the unit: its exponential stays finite."""
