"""What rules of the studies share: their configuration, and the networks that are compared."""

COMPARISON = configuration.read(ROOT / "studies/config.yaml")
NETWORKS = [
    f"{summary}-{inference}"
    for summary in COMPARISON["summaries"]
    for inference in COMPARISON["inferences"]
]
# Scripts import the studies from the project's folder, wherever they run.
FOLDERS = filter(None, [str(ROOT), os.getenv("PYTHONPATH")])
os.environ.update(PYTHONPATH=os.pathsep.join(FOLDERS))


wildcard_constraints:
    network="[a-z_]+-[a-z_]+",


def network_of(wildcards):
    """The settings of a combination of networks of one motion, of the kinds in its name."""
    summary, inference = wildcards.network.split("-")
    sections = config["network"][wildcards.motion]
    chosen = {
        "summary": {**sections["summary"], "kind": summary},
        "inference": {**sections["inference"], "kind": inference},
    }
    return configuration.chosen_network(chosen)


def training_of(wildcards):
    """The settings of the training of one motion, of no more steps than the comparison has."""
    settings = config["training"][wildcards.motion]
    return {**settings, "steps": min(COMPARISON["steps"], settings["steps"])}
