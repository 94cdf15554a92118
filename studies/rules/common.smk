"""What rules of the studies share: the networks that are compared, and how."""

import os

from breaker.configuration.loading import chosen_network

SUMMARIES = ["time_series"]
INFERENCES = ["flow_matching", "coupling_flow"]  # each with each summary
NETWORKS = [f"{summary}-{inference}" for summary in SUMMARIES for inference in INFERENCES]
STEPS = 3000  # optimiser steps of each, those of `training` at most

# Scripts import the studies from the project's folder, wherever they run.
FOLDERS = filter(None, [os.path.dirname(workflow.basedir), os.getenv("PYTHONPATH")])
os.environ.update(PYTHONPATH=os.pathsep.join(FOLDERS))


wildcard_constraints:
    network="[a-z_]+-[a-z_]+",


def network_of(wildcards):
    """The settings of a combination of networks of one motion, of the kinds in its name."""
    summary, inference = wildcards.network.split("-")
    sections = config["network"][wildcards.motion]
    chosen = {
        "summary": {**sections["summary"], "kind": summary},
        "inference": {**sections["inference"], "kind": inference},
    }
    return chosen_network(chosen)


def training_of(wildcards):
    """The settings of the training of one motion, of no more steps than the comparison has."""
    settings = config["training"][wildcards.motion]
    return {**settings, "steps": min(STEPS, settings["steps"])}
