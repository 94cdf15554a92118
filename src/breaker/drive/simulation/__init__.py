"""Simulated drives whose truth is known: richer than the model, wearing out, written as files.

A family of such drives, their integration, the endurance rig that is one of them, and the ways in
which instruments write records.
"""
