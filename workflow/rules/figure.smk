"""What all figures have in common: a script of their name draws them, for the report too."""


def figure(name, category, *, label=None, of="_{motion}", by=None, params=None, **inputs):
    """Make the rule of one figure.

    Args:
        name: Of the file, its caption, and its script unless ``by`` names that.
        category: Chapter of the report.
        label: Its name in the report, if it is another.
        of: Wildcards in the file's name.
        by: Name of the script, if it is that of another figure.
        params: Settings that the script takes.
        inputs: Files that it takes, by name.
    """

    rule:
        name:
            f"figure_{name}"
        input:
            **inputs,
        output:
            page(f"figures/{name}{of}.png", category, label or name.replace("_", " "), name),
        log:
            f"logs/figures/{name}{of}.log",
        params:
            **(params or {}),
        script:
            f"../scripts/figure_{by or name}.py"
