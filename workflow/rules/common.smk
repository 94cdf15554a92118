"""Configuration, and the names that several rules share."""

import os

from breaker.drive.family.training_origin import trained_on
from breaker.quantities.size import Size
from breaker.quantities.speeds import speeds_of, with_named
from breaker.shipped import FAMILIES, KINDS, model_file
from breaker.workflow.jobs import missing_packages

# Jobs run on what was checked before the first one.
if snakemake_internals.is_first_process(workflow):
    try:
        configuration.check(config, files=snakemake_internals.configuration_files(workflow))
    except ConfigurationError as error:
        raise WorkflowError(str(error)) from None

# With a deployment, jobs have environments of their own. A plan or a lint needs no more than this.
MISSING = "" if snakemake_internals.deploys(workflow) else missing_packages()
if MISSING and snakemake_internals.is_first_process(workflow):
    logger.warning(MISSING)


onstart:
    if MISSING:
        raise WorkflowError(MISSING)


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
DEFINED = with_named(config["speeds"], config["limits"])
SPEEDS = {each.name: each.points for each in speeds_of(DEFINED, Size(**config["size"]))}
GRID = {key: config["sensor"][key] for key in ("start", "stop", "samples")}
OWN_CURVES = config["endurance"]["curves"]
# Store of the stand-in's true parameters; real measurements have none.
TRUTH = "results/rig/truth.zarr" if OWN_CURVES is None else []
if ROOT.is_dir():  # not in a repository: then a clone has to be named
    os.environ.update(BREAKER_ROOT=str(ROOT))  # for the script beside the environment


wildcard_constraints:
    motion="closing|opening",
    source="closing|opening|both",
    origin="shipped|trained",
    chunk=r"\d\d\d+",
    kind="levels|changes",
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
    kind = "_corrected" if config["validation"]["posterior"] == "corrected" else ""
    return f"results/validation/{wildcards.motion}{kind}_seed{SEED}.zarr"


def shard_of_family(wildcards):
    """How many drives a shard has."""
    every, more = divmod(config["family"]["drives"], config["family"]["shards"])
    return every + (int(wildcards.shard) < more)


def network_of_family(wildcards):
    """The file of a network, of the package or of this run."""
    if wildcards.origin == "shipped":
        return local(str(model_file(config["family"]["name"], wildcards.kind)))
    return f"results/family/trained/{wildcards.kind}.safetensors"


def judged_family(origin, sources):
    """Figures and table of how good networks are."""
    figures = expand(
        f"figures/{{name}}_family_{origin}_{{source}}.png", name=FAMILY_FIGURES, source=sources
    )
    return [*figures, f"results/family/{origin}/quality.csv"]


def judged_shipped(wildcards):
    """The same of the networks that ship; nothing where they are of another prior or family."""
    name, drives = config["family"]["name"], (config["prior"], config["family"])
    fit = name in FAMILIES and all(trained_on(model_file(name, kind), *drives) for kind in KINDS)
    return judged_family("shipped", SOURCES[-1:]) if fit else []


def complete_rules():
    """Give rules with a script what all of them have in common, once all are stated."""
    if gone := snakemake_internals.lacking(workflow):
        raise WorkflowError(gone)
    snakemake_internals.complete_rules(workflow, resources_of)
