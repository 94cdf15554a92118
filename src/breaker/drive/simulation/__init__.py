"""Simulated drives whose truth is known: richer than the model, wearing out, written as files."""
