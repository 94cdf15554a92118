"""Neural networks: summary networks, conditional densities, and their trainer.

They know nothing of breakers: records are rows ``(n, t)``, and what is inferred are standardised
numbers ``(n, q)``. ``summary.build`` makes the two networks of a posterior from their settings:

- A summary network maps records ``(n, t)`` to features ``(n, s)``. ``freeze`` sets, once, by what
  numbers its input is scaled.
- An inference network is a density of ``(n, q)`` given features, with ``loss``, ``sample`` and
  ``log_prob`` as those of ``FlowMatching``. ``solves`` says whether solver steps matter.

``mixture`` has the density of the family's networks; ``training`` trains any of them.
"""

CLIP = 5.0
"""Of residuals as inputs: one far outlier must not drive a network of later dimensions."""

WIDEST = 7.0
"""Largest logarithm of a scale or width, 1100 times the unit: its exponential stays finite."""
