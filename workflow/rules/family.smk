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
