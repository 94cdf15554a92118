"""Configuration, and the names that several rules share."""

import os
from pathlib import Path

from breaker.workflow import configuration, modules_of

if workflow.is_main_process:  # jobs run on what was checked before the first one
    try:
        configuration.check(
            config,
            schema=Path(workflow.basedir) / "workflow/schemas/config.schema.yaml",
            files=workflow.configfiles,
        )
    except configuration.ConfigurationError as error:
        raise WorkflowError(str(error)) from None


def ordered(value):
    """A part of the configuration with its keys in order, at any depth.

    An overlay puts its own keys first, and Snakemake takes another order for another setting.
    """
    if isinstance(value, dict):
        return {key: ordered(value[key]) for key in sorted(value)}
    return value


for section in config:
    config[section] = ordered(config[section])

MOTIONS = config["motions"]
SOURCES = [*MOTIONS, "both"] if len(MOTIONS) == 2 else MOTIONS
SEED = config["validation"]["seed"]
GRID = {key: config["sensor"][key] for key in ("start", "stop", "samples")}
# Store of what the model leaves out; none where the model is taken for right.
DISCREPANCY = "results/discrepancy.zarr" if config["discrepancy"]["components"] else []
OWN_CURVES = config["endurance"]["curves"]
# Store of the stand-in's true parameters; real measurements have none.
TRUTH = "results/rig/truth.zarr" if OWN_CURVES is None else []
ENVIRONMENT = "../../envs/breaker.yaml"
os.environ.update(BREAKER_ROOT=str(workflow.basedir))  # for the script beside the environment


wildcard_constraints:
    motion="closing|opening",
    source="closing|opening|both",
    chunk=r"\d\d\d+",
    network="[a-z_]+-[a-z_]+",
    shard=r"\d\d\d+",
    seed=r"\d+",


def page(path, category, figure, caption):
    """A file in the report. What both motions have in common comes after each of them."""
    place = "source" if "{source}" in path else "motion"

    def labels(wildcards):
        motion = wildcards.get(place, "both")
        return {"figure": figure, "motion": "together" if motion == "both" else motion}

    return report(path, caption=f"../report/{caption}.rst", category=category, labels=labels)


def validated(wildcards):
    """The validation that figures show: of the network's posteriors, or of the corrected ones."""
    corrected = "_corrected" if config["validation"]["posterior"] == "corrected" else ""
    return f"results/validation/{wildcards.motion}{corrected}_seed{SEED}.zarr"


def network_of(wildcards):
    """The settings of a combination of networks of one motion, of the kinds in its name."""
    summary, inference = wildcards.network.split("-")
    sections = config["network"][wildcards.motion]
    chosen = {
        "summary": {**sections["summary"], "kind": summary},
        "inference": {**sections["inference"], "kind": inference},
    }
    return configuration.chosen_network(chosen)
