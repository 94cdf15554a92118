"""Names and functions that several rules share."""

from functools import cache
from hashlib import sha256
from itertools import product
from math import ceil
from pathlib import Path

from breaker.common.named_functions import file_of
from breaker.configuration.data_files import advice_of, family_of, simulated_test
from breaker.configuration.loading import of_motion
from breaker.family.network_files import header_of, unfit
from breaker.model.parameters import Size
from breaker.model.quantities import OF_STROKE, speeds_of
from breaker.paper import is_exact
from breaker.shipped import FAMILIES, KINDS, model_file
from breaker.workflow.dependencies import modules_of

MOTIONS = config["motions"]
SOURCES = [*MOTIONS, "both"] if len(MOTIONS) == 2 else MOTIONS
SEED = config["validation"]["seed"]
DEFINED = {name: points for name, points in OF_STROKE.items() if name in str(config["limits"])}
DEFINED |= config["speeds"]
SPEEDS = {speed.name: speed.points for speed in speeds_of(DEFINED, Size(**config["size"]))}
GRID = {key: config["sensor"][key] for key in ("start", "stop", "samples")}
OWN_CURVES = config["endurance"]["curves"]
# The user's functions that replace the drive and its prior, and whether exact posteriors exist.
MODEL = config["model"]
EXACT = is_exact(config)
# Whether there are measured curves: the simulated test needs the paper's drive.
MEASURED = EXACT or OWN_CURVES is not None
# Stores of inferred operations: by networks trained here, and by shipped networks of families.
BY = {"paper": "results/endurance/{motion}.zarr"}
if EXACT:
    BY["family"] = "results/endurance/{motion}_family.zarr"
# Store of the true parameters of the simulated endurance test; measurements have none.
TRUTH = "results/rig/truth.zarr" if OWN_CURVES is None else []
# Ranges of the family of drives, and the drive of the simulated endurance test.
FAMILY = family_of(config["family"]["name"])
TEST = simulated_test(config)
FIGURES_OF_FAMILY = ["sbc", "contraction", "recovery", "pairs"]


wildcard_constraints:
    motion="closing|opening",
    source="closing|opening|both",
    origin="shipped|trained",
    chunk=r"\d\d\d+",
    kind="levels|changes",
    shard=r"\d\d\d+",
    seed=r"\d+",


def code(script):
    """Return a script and the modules that it imports, a change of which reruns its rule.

    They include files of the user's functions if the script builds the model or a network. The
    script of a remote repository is left out, because its path in Snakemake's cache varies.
    """
    file = Path(code.__code__.co_filename).parents[1] / "scripts" / f"{script}.py"
    here = file.exists()
    files = modules_of(
        file if here else workflow.source_path(f"../scripts/{script}.py"), itself=here
    )
    named = MODEL.values() if any("joint_model" in file for file in files) else []
    if any(file.endswith("paper/posterior.py") for file in files):
        networks = [of_motion(config, motion)["network"] for motion in MOTIONS]
        named = [*named, *(network["summary"]["kind"] for network in networks)]
    own = {str(file_of(kind)) for kind in named if kind and ":" in kind}
    return [local(file) for file in (*files, *sorted(own))]


def page(path, category, figure, caption):
    """Return a file of the report; files of both motions follow files of single motions."""
    place = "source" if "{source}" in path else "motion"

    def labels(wildcards):
        motion = wildcards.get(place, "both")
        return {"figure": figure, "motion": "together" if motion == "both" else motion}

    return report(path, caption=f"../report/{caption}.rst", category=category, labels=labels)


def network_of_motion(wildcards):
    """Return the settings of a motion's networks, for the chosen kinds."""
    return of_motion(config, wildcards.motion)["network"]


def training_of_motion(wildcards):
    """Return the settings of a motion's training."""
    return of_motion(config, wildcards.motion)["training"]


def training_minutes(training, attempt):
    """Return the time limit of a training, minutes: twice the time of a busy core, and a start."""
    return attempt * (5 + ceil(2.5e-6 * training["steps"] * training["batch"]))


def validated(wildcards):
    """Return the validation for figures: of the network's posteriors, or of corrected ones."""
    kind = "_corrected" if config["validation"]["posterior"] == "corrected" else ""
    return f"results/validation/{wildcards.motion}{kind}_seed{SEED}.zarr"


def shard_of_family(wildcards):
    """Return the number of drives of a shard."""
    every, more = divmod(config["family"]["drives"], config["family"]["shards"])
    return every + (int(wildcards.shard) < more)


def trained_network(wildcards):
    """Return the file of a network trained here; a shipped network is a part of the package."""
    trained = f"results/family/trained/{wildcards.kind}.safetensors"
    return trained if wildcards.origin == "trained" else []


@cache
def checksum(family, kind):
    """Return the checksum of a shipped network, which does not depend on its path."""
    return sha256(model_file(family, kind).read_bytes()).hexdigest()


def shipped_network(wildcards):
    """Return the checksum of a shipped network that fits the configuration, else None."""
    if wildcards.origin == "trained":
        return None
    name, kind = config["family"]["name"], wildcards.kind
    ships = name in FAMILIES
    wrong = (
        unfit(model_file(name, kind), config, kind, FAMILY) if ships else [f"family.name: {name}"]
    )
    if wrong:
        raise WorkflowError(
            "The package ships no network of the configured prior and family:\n  "
            + "\n  ".join(wrong)
            + "\nTrain one with `snakemake -c2 family`, or configure a family that ships: the "
            "default, or config/any.yaml."
        )
    return checksum(name, kind)


def shipped_networks(wildcards):
    """Return the checksums of all shipped networks, a change of which reruns inferences."""
    return [checksum(*names) for names in product(FAMILIES, KINDS)]


def judged_family(origin, sources):
    """Return the figures and the table of the quality of networks."""
    figure = "figures/{name}_family_{origin}_{source}.png"
    figures = expand(figure, name=FIGURES_OF_FAMILY, origin=origin, source=sources)
    return [*figures, f"results/family/{origin}/quality.csv"]


# Figures of `all`: for each motion, as in the paper, and for the life.
FIGURES = ["prior_predictive", "loss", "sbc", "contraction", "recovery", "pairs"]
FIGURES += ["posterior_predictive"]
EXACT_FIGURES = ["sbc_reader", "exactness", "identifiability", "endurance_predictive", "evolution"]
FIGURES_OF_LIFE = ["verdict", "health", "changepoint", "remaining_life", "changes"]


def of_paper(wildcards=None):
    """Return Figures 3 to 10 of the paper, tables and numbers, as far as the model allows."""
    figures, table = "figures/{figure}_{motion}.png", "results/{table}/{motion}_seed{seed}.csv"
    wanted = expand(figures, figure=FIGURES, motion=MOTIONS)
    wanted += expand("results/endurance/{motion}.csv", motion=MOTIONS) if MEASURED else []
    if not EXACT:
        logger.warning(
            "Correction, exactness, identifiability, family and decisions are left out: "
            "without an exact density of the model they are not defined."
        )
        return wanted
    wanted += expand(figures, figure=EXACT_FIGURES, motion=MOTIONS)
    wanted += expand(table, table=["quality", "exactness"], motion=MOTIONS, seed=SEED)
    return [*wanted, "results/numbers.csv"]


def of_life(wildcards=None):
    """Return the tables of decisions, with their figures and the first page."""
    if not EXACT:
        return []
    tables = expand("results/{table}.csv", table=["decisions", "limits", "changes"])
    figures = expand("figures/{figure}.png", figure=FIGURES_OF_LIFE)
    return [*tables, *figures, "results/first_page.html"]
