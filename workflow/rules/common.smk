"""Configuration, the names that several rules share, and what a script is made of."""

from functools import cache
from math import ceil
from pathlib import Path

from breaker.workflow import configuration, modules_of
from breaker.records import list_curves

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
SEED = config["validation"]["seed"]
FIGURES = [
    "prior_predictive",
    "loss",
    "sbc",
    "sbc_reader",
    "contraction",
    "recovery",
    "pairs",
    "posterior_predictive",
    "exactness",
    "identifiability",
    "endurance_predictive",
    "evolution",
]
DECISIONS = ["verdict", "health", "remaining_life"]
ENVIRONMENT = "../../envs/breaker.yaml"
NETWORKS = [
    f"{summary}-{inference}"
    for summary in config["comparison"]["summaries"]
    for inference in config["comparison"]["inferences"]
]


wildcard_constraints:
    motion="closing|opening",
    source="closing|opening|both",
    chunk=r"\d\d\d+",
    network="[a-z_]+-[a-z_]+",
    shard=r"\d\d\d+",
    seed=r"\d+",


def sources(script):
    """The modules of the package that a script uses, as inputs of its rule."""
    return modules_of(Path(workflow.basedir) / "workflow/scripts" / script)


def time_grid():
    """What of the sensor the reader depends on."""
    return {key: config["sensor"][key] for key in ("start", "stop", "samples")}


def network_of(wildcards):
    """The settings of a combination of networks of one motion, of the kinds in its name."""
    summary, inference = wildcards.network.split("-")
    sections = config["network"][wildcards.motion]
    chosen = {
        "summary": {**sections["summary"], "kind": summary},
        "inference": {**sections["inference"], "kind": inference},
    }
    return configuration.chosen_network(chosen)


def bank_shards(wildcards):
    """The shards of a motion's bank, named from the configuration."""
    return [
        f"results/bank/{wildcards.motion}/shard_{shard:03d}.zarr"
        for shard in range(config["bank"]["shards"])
    ]


def curve_folder(wildcards):
    """Where the curve files of a motion are: the stand-in's own, or the user's."""
    return f"{config['endurance']['curves'] or 'results/rig/curves'}/{wildcards.motion}"


def curve_files(wildcards):
    """What the curves of a chunk are read from: the stand-in's folder, or the chunk's own files.

    A file each, so that appended operations run their own chunk again and no other.
    """
    folder, size = curve_folder(wildcards), config["endurance"]["operations_per_job"]
    if config["endurance"]["curves"] is None:
        return {"folder": folder}
    first = int(wildcards.chunk) * size
    return {"files": [str(file) for _, file in list_curves(folder)[first : first + size]]}


def chunks(wildcards):
    """The numbers of the chunks in which the operations of a motion are read and inferred."""
    if config["endurance"]["curves"] is None:
        operations = config["rig"]["operations"]
    else:
        operations = len(list_curves(curve_folder(wildcards)))
    count = ceil(operations / config["endurance"]["operations_per_job"])
    return [f"{chunk:03d}" for chunk in range(count)]


def curve_chunks(wildcards):
    """All curves of a motion, as read."""
    return [
        f"results/endurance/{wildcards.motion}/curves_{chunk}.zarr" for chunk in chunks(wildcards)
    ]


def corrected_chunks(wildcards):
    """All operations of a motion, as corrected."""
    return [
        f"results/endurance/{wildcards.motion}/corrected_{chunk}.zarr"
        for chunk in chunks(wildcards)
    ]


def validated(wildcards):
    """The validation that figures show: of the network's posteriors, or of the corrected ones."""
    corrected = "_corrected" if config["validation"]["posterior"] == "corrected" else ""
    return f"results/validation/{wildcards.motion}{corrected}_seed{SEED}.zarr"


def inferred_chunks(wildcards):
    """All operations of a motion, as inferred."""
    return [
        f"results/endurance/{wildcards.motion}/inferred_{chunk}.zarr" for chunk in chunks(wildcards)
    ]


def effective_values(wildcards):
    """The stand-in's effective values of a motion; real measurements have none, nor have both."""
    motion = wildcards.get("motion", wildcards.get("source"))
    if config["endurance"]["curves"] is None and motion in MOTIONS:
        return {"effective": f"results/rig/{motion}_effective.zarr"}
    return {}


SOURCES = [*MOTIONS, "both"] if len(MOTIONS) == 2 else MOTIONS


@cache
def operation_numbers(motion):
    """The numbers of the operations of a motion, rising."""
    if config["endurance"]["curves"] is None:
        return list(range(1, config["rig"]["operations"] + 1))
    return [number for number, _ in list_curves(f"{config['endurance']['curves']}/{motion}")]


@cache
def paired_chunks():
    """The numbers of all operations of any motion, in chunks: what trends go through."""
    numbers = sorted(set().union(*(operation_numbers(motion) for motion in MOTIONS)))
    size = config["endurance"]["operations_per_job"]
    return [numbers[first : first + size] for first in range(0, len(numbers), size)]


def paired_numbers(wildcards):
    """The numbers of the operations of a chunk of both motions."""
    return paired_chunks()[int(wildcards.chunk)]


def corrected_of(motion):
    """What holds the operations of a chunk of both motions in one of them."""

    def files(wildcards):
        wanted, size = set(paired_numbers(wildcards)), config["endurance"]["operations_per_job"]
        places = [i for i, number in enumerate(operation_numbers(motion)) if number in wanted]
        return [
            f"results/endurance/{motion}/corrected_{chunk:03d}.zarr"
            for chunk in sorted({place // size for place in places}) or [0]
        ]

    return files


def corrected_of_source(wildcards):
    """What holds the operations of a chunk in the motions of a source."""
    motions = MOTIONS if wildcards.source == "both" else [wildcards.source]
    return {motion: corrected_of(motion)(wildcards) for motion in motions}


def state_before(wildcards):
    """The state of a trend after the chunk before; the first one has none."""
    chunk = int(wildcards.chunk)
    return [f"results/trend/{wildcards.source}/state_{chunk - 1:03d}.zarr"] if chunk else []


def all_chunks(pattern):
    """A file of every chunk of both motions."""

    def files(wildcards):
        return [
            pattern.format(chunk=f"{chunk:03d}", **wildcards)
            for chunk in range(len(paired_chunks()))
        ]

    return files


def effective_of_all(wildcards):
    """The stand-in's effective values in every motion; real measurements have none."""
    if config["endurance"]["curves"] is None:
        return [f"results/rig/{motion}_effective.zarr" for motion in MOTIONS]
    return []


def life_jobs(wildcards):
    """What follows the lives of a seed, a few in a job."""
    jobs = ceil(config["lives"]["lives"] / config["lives"]["lives_per_job"])
    return [f"results/lives/seed{wildcards.seed}/lives_{job:03d}.zarr" for job in range(jobs)]


def medians_of_source(wildcards):
    """What holds the posterior medians of single operations of a motion; of both there are none."""
    return [] if wildcards.source == "both" else [f"results/endurance/{wildcards.source}.zarr"]
