"""Posteriors of records: trained networks, their correction to the exact posterior, and checks.

``Posterior`` holds a trained network and its settings in one file; it draws, evaluates its density
and predicts records. Importance sampling corrects its draws and measures its error. Needs torch.
"""
