"""What rules of the studies share: the networks that are compared, and how."""

import os

from breaker.configuration.loading import merge, of_motion

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
    chosen = {"summary": {"kind": summary}, "inference": {"kind": inference}}
    return of_motion(merge(config, {"network": chosen}), wildcards.motion)["network"]


def training_of(wildcards):
    """The settings of the training of one motion, of no more steps than the comparison has."""
    settings = of_motion(config, wildcards.motion)["training"]
    return {**settings, "steps": min(STEPS, settings["steps"])}
