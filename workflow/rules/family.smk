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


# The paper's checks of the network of levels, on drives that it was not trained on.
FAMILY_FIGURES = {"sbc": {"subject": "calibration on held-out drives of the family"}}
FAMILY_FIGURES |= {
    "contraction": {"prior": config["prior"], "onset_sd": 0.0, "setting": ", family of drives"},
    "recovery": {},
}
for name, params in FAMILY_FIGURES.items():
    figure(
        f"{name}_family",
        "3 Validation",
        label=f"{name} of the family",
        of="_{source}",
        by=name,
        params=params | {"motions": lambda wildcards: wildcards.source},
        validation="results/family/levels_{source}.zarr",
    )


rule family:
    """The networks of the family, and how good they are."""
    input:
        expand("results/family/{kind}.safetensors", kind=["levels", "changes"]),
        expand("figures/{name}_family_{source}.png", name=FAMILY_FIGURES, source=SOURCES),
        "results/family/quality.csv",
