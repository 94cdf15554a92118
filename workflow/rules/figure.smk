"""What all figures have in common: a script draws them, for the report too."""


def figure(
    name, category, *, label=None, of="_{motion}", by=None, within=None, params=None, **inputs
):
    """Make the rule of one figure.

    Args:
        name: Of the file, its caption, and its script unless ``by`` names that.
        category: Chapter of the report.
        label: Its name in the report, if it is another.
        of: Wildcards in the file's name.
        by: Name of the script, if it is that of another figure.
        within: Module of ``breaker.figures`` whose function of the figure's name takes the inputs as
            they are, and the wildcards: then the figure needs no script of its own.
        params: Settings that the script takes.
        inputs: Files that it takes, by name.
    """
    if within:
        params = {"within": f"breaker.figures.{within}", "figure": name}

    rule:
        name:
            f"figure_{name}"
        input:
            **inputs,
        output:
            page(f"figures/{name}{of}.png", category, label or name.replace("_", " "), name),
        log:
            f"logs/figures/{name}{of}.log",
        conda:
            "../../envs/breaker.yaml"
        params:
            **(params or {}),
        script:
            "../scripts/figure.py" if within else f"../scripts/figure_{by or name}.py"
