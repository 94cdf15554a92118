"""Networks of a family: the bank of its drives, training on it, and quality of the networks.

`validate_shipped` judges shipped networks on newly simulated drives. `family` trains networks, and
judges them on the same drives. `all` does neither.
"""

FAMILY_TRAINING = config["family"]["training"]


rule family_shard:
    """Simulate one shard of the bank of the family: both motions of drives, new and worn."""
    input:
        code=code("family_shard"),
    output:
        directory("results/family/bank/shard_{shard}.zarr"),
    log:
        "logs/family/bank_{shard}.log",
    benchmark:
        "results/benchmarks/family_bank_{shard}.tsv"
    priority: 10  # start the longest chain first
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        prior=config["prior"],
        family=FAMILY,
        part=lambda wildcards: int(wildcards.shard),
        drives=shard_of_family,
    script:
        "../scripts/family_shard.py"


use rule family_shard as family_held_out with:
    output:
        directory("results/family/held_out.zarr"),
    log:
        "logs/family/held_out.log",
    benchmark:
        "results/benchmarks/family_held_out.tsv"
    priority: 0
    params:
        seed=config["seed"],
        prior=config["prior"],
        family=FAMILY,
        part="held out",
        drives=FAMILY_TRAINING["held_out_curves"],


rule family_train:
    """Train the network of levels or of changes."""
    input:
        shards=expand(
            "results/family/bank/shard_{shard:03d}.zarr", shard=range(config["family"]["shards"])
        ),
        code=code("family_train"),
    output:
        network="results/family/trained/{kind}.safetensors",
        history=directory("results/family/trained/{kind}_history.zarr"),
    log:
        "logs/family/train_{kind}.log",
    benchmark:
        "results/benchmarks/family_train_{kind}.tsv"
    priority: 10
    conda:
        "../../envs/breaker.yaml"
    threads: config["training"]["threads"]
    resources:
        gpu=int(config["training"]["device"] == "cuda"),
        workers=FAMILY_TRAINING["workers"],
        mem_mb=lambda wildcards, attempt: attempt * (1000 + config["family"]["drives"] // 80),
        runtime=lambda wildcards, attempt: training_minutes(FAMILY_TRAINING, attempt),
    params:
        header=lambda wildcards: header_of(config, wildcards.kind, FAMILY),
        device=config["training"]["device"],
    script:
        "../scripts/family_train.py"


rule validate_family:
    """Draw from the posteriors of held-out drives."""
    input:
        drives="results/family/held_out.zarr",
        network=trained_network,
        code=code("validate_family"),
    output:
        directory("results/family/{origin}/{kind}_{source}.zarr"),
    log:
        "logs/family/validate_{origin}_{kind}_{source}.log",
    benchmark:
        "results/benchmarks/family_validate_{origin}_{kind}_{source}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["validation"]["seed"],
        draws=config["validation"]["draws"],
        family=config["family"]["name"],
        shipped=shipped_network,
    script:
        "../scripts/validate_family.py"


rule family_quality:
    """Tabulate calibration, width and error on held-out drives, one row an output and motion."""
    input:
        levels=expand("results/family/{{origin}}/levels_{source}.zarr", source=SOURCES),
        changes=expand("results/family/{{origin}}/changes_{source}.zarr", source=SOURCES),
        code=code("family_quality"),
    output:
        page(
            "results/family/{origin}/quality.csv",
            "3 Validation",
            "table of the family",
            "family_table",
        ),
    log:
        "logs/family/quality_{origin}.log",
    benchmark:
        "results/benchmarks/family_quality_{origin}.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/family_quality.py"


rule figure_validation_family:
    """Draw calibration, contraction, recovery and pairs on held-out drives."""
    input:
        validation="results/family/{origin}/levels_{source}.zarr",
        prior=f"results/prior_predictive/{MOTIONS[0]}.zarr",
        code=code("figure_validation"),
    output:
        sbc=page(
            "figures/sbc_family_{origin}_{source}.png",
            "3 Validation",
            "sbc of the family",
            "sbc_family",
        ),
        contraction=page(
            "figures/contraction_family_{origin}_{source}.png",
            "3 Validation",
            "contraction of the family",
            "contraction_family",
        ),
        recovery=page(
            "figures/recovery_family_{origin}_{source}.png",
            "3 Validation",
            "recovery of the family",
            "recovery_family",
        ),
        pairs=page(
            "figures/pairs_family_{origin}_{source}.png",
            "3 Validation",
            "pairs of the family",
            "pairs_family",
        ),
    log:
        "logs/figures/validation_family_{origin}_{source}.log",
    benchmark:
        "results/benchmarks/figures_validation_family_{origin}_{source}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        subject="held-out drives of the family",
    script:
        "../scripts/figure_validation.py"


rule family:
    """Train networks on the configured family, and judge them."""
    input:
        expand("results/family/trained/{kind}.safetensors", kind=KINDS),
        judged_family("trained", SOURCES),


rule validate_shipped:
    """Judge the shipped networks, which do not change from run to run."""
    input:
        judged_family("shipped", SOURCES[-1:]),
