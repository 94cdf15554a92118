"""Networks of a family: the bank of its drives.

Needs nothing but the configuration. Makes one Zarr store a shard, each a job of its own, whose
content depends on the seed, the prior, the family and its number.
"""

FAMILY_SHARDS = expand(
    "results/family/bank/shard_{shard:03d}.zarr", shard=range(config["family"]["shards"])
)


rule family_shard:
    """One shard of the bank of the family: both motions of its drives, new and worn."""
    output:
        directory("results/family/bank/shard_{shard}.zarr"),
    log:
        "logs/family/bank_{shard}.log",
    priority: 10  # the longest chain first: what follows fills the cores after it
    params:
        seed=config["seed"],
        prior=config["prior"],
        family={key: value for key, value in config["family"].items() if key != "name"},
    script:
        "../scripts/family_shard.py"


rule family_train:
    """Train the network of levels, or that of changes."""
    input:
        shards=FAMILY_SHARDS,
    output:
        network="results/family/{kind}.safetensors",
        history=directory("results/family/{kind}_history.zarr"),
    log:
        "logs/family/train_{kind}.log",
    priority: 10
    threads: config["family_networks"]["training"]["threads"]
    params:
        seed=config["seed"],
        prior=config["prior"],
        family=config["family"],
        networks=config["family_networks"],
        checkpoint="checkpoints/family_{kind}.pt",
    script:
        "../scripts/family_train.py"


rule validate_family:
    """Draw from the posterior of held-out drives of the family, by the files that answers are by."""
    input:
        shards=FAMILY_SHARDS,
        network="results/family/{kind}.safetensors",
    output:
        directory("results/family/{kind}_{source}.zarr"),
    log:
        "logs/family/validate_{kind}_{source}.log",
    params:
        seed=config["validation"]["seed"],
        draws=config["validation"]["draws"],
        networks=config["family_networks"],
    script:
        "../scripts/validate_family.py"


rule family_quality:
    """One row an output and motion: calibration, width and error on held-out drives."""
    input:
        levels=expand("results/family/levels_{source}.zarr", source=SOURCES),
        changes=expand("results/family/changes_{source}.zarr", source=SOURCES),
    output:
        page("results/family/quality.csv", "3 Validation", "table of the family", "family_table"),
    log:
        "logs/family/quality.log",
    script:
        "../scripts/family_quality.py"
