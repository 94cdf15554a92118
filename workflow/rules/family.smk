"""Networks of a family: the bank of its drives, trainings on it, and how good networks are.

`all` judges those that ship, where they are of the configured family, on drives that it simulates
anew; `family` trains networks, and judges them on the same drives.
"""

from breaker.drive.family.training_origin import deciding
from breaker.shipped import KINDS

FAMILY_SHARDS = expand(
    "results/family/bank/shard_{shard:03d}.zarr", shard=range(config["family"]["shards"])
)


DRIVES = {key: value for key, value in config["family"].items() if key != "name"}


rule family_shard:
    """One shard of the bank of the family: both motions of its drives, new and worn."""
    output:
        directory("results/family/bank/shard_{shard}.zarr"),
    log:
        "logs/family/bank_{shard}.log",
    priority: 10  # the longest chain first: what follows fills the cores after it
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        prior=config["prior"],
        family=DRIVES,
        part=lambda wildcards: int(wildcards.shard),
        drives=shard_of_family,
    script:
        "../scripts/family_shard.py"


use rule family_shard as family_held_out with:
    output:
        directory("results/family/held_out.zarr"),
    log:
        "logs/family/held_out.log",
    priority: 0
    params:
        seed=config["seed"],
        prior=config["prior"],
        family=DRIVES,
        part="held out",
        drives=config["family_networks"]["training"]["held_out_curves"],


rule family_train:
    """Train the network of levels, or that of changes."""
    input:
        shards=FAMILY_SHARDS,
    output:
        network="results/family/trained/{kind}.safetensors",
        history=directory("results/family/trained/{kind}_history.zarr"),
    log:
        "logs/family/train_{kind}.log",
    priority: 10
    conda:
        "../../envs/breaker.yaml"
    threads: config["family_networks"]["training"]["threads"]
    resources:
        gpu=int(config["family_networks"]["training"]["device"] == "cuda"),
        workers=config["family_networks"]["training"]["workers"],
    params:
        seed=config["seed"],
        prior=config["prior"],
        family=config["family"],
        networks=deciding(config["family_networks"]),
        checkpoint=placed("checkpoints/family_{kind}.pt"),
    script:
        "../scripts/family_train.py"


rule validate_family:
    """Draw from the posterior of drives that no training has seen."""
    input:
        drives="results/family/held_out.zarr",
        network=network_of_family,
    output:
        directory("results/family/{origin}/{kind}_{source}.zarr"),
    log:
        "logs/family/validate_{origin}_{kind}_{source}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["validation"]["seed"],
        draws=config["validation"]["draws"],
    script:
        "../scripts/validate_family.py"


rule family_quality:
    """One row an output and motion: calibration, width and error on held-out drives."""
    input:
        levels=expand("results/family/{{origin}}/levels_{source}.zarr", source=SOURCES),
        changes=expand("results/family/{{origin}}/changes_{source}.zarr", source=SOURCES),
    output:
        page(
            "results/family/{origin}/quality.csv",
            "3 Validation",
            "table of the family",
            "family_table",
        ),
    log:
        "logs/family/quality_{origin}.log",
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/family_quality.py"


# The paper's checks of the network of levels, on drives that it was not trained on.
FAMILY = {"of": "family of drives"}
FAMILY_FIGURES = {
    "sbc": {"shows": "ranks", "words": FAMILY | {"subject": "calibration on held-out drives"}},
    "contraction": {"shows": "scores", "words": FAMILY, "prior": config["prior"], "onset_sd": 0.0},
    "recovery": {"shows": "recovery", "words": FAMILY},
    "pairs": {"words": FAMILY},
}
PRIOR = f"results/prior_predictive/{MOTIONS[0]}.zarr"
for name, params in FAMILY_FIGURES.items():
    figure(
        f"{name}_family",
        "3 Validation",
        label=f"{name} of the family",
        of="_{origin}_{source}",
        by="pairs" if name == "pairs" else "validation",
        params=params,
        validation="results/family/{origin}/levels_{source}.zarr",
        **({"prior": PRIOR} if name == "pairs" else {}),
    )


rule family:
    """Networks trained on the configured family, and how good they are."""
    input:
        expand("results/family/trained/{kind}.safetensors", kind=KINDS),
        judged_family("trained", SOURCES),
