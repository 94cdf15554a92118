"""Files that ship with the package: families of drives, networks trained on them, and other data.

The networks are those of the families here (``make ship``); a test compares them.
"""

import json
from pathlib import Path

_HERE = Path(__file__).parent

CARD = _HERE / "MODEL_CARD.md"  # what the models are, for whom, and how good
ADVICE = _HERE / "advice.yaml"  # where to look first, by quantity
SIMULATED_TEST = _HERE / "simulated_test.yaml"  # drive, wear and sensor of this endurance test
FAMILIES = ("medium_voltage", "any")  # families of drives, in the order in which they are tried
KINDS = ("levels", "changes")  # networks of each


def model_file(family: str, kind: str) -> Path:
    """Return the file of a network: of a family, and one of ``KINDS``."""
    return _HERE / f"{family}_{kind}.safetensors"


def family_file(name: str) -> Path:
    """Return the file with the definition of a family."""
    return _HERE / "families" / f"{name}.yaml"


def widening(family: str) -> dict[int, dict[str, float]]:
    """Return factors by output, by the number of motions that tell a drive; none if not measured.

    The posterior of the state network is made wider by these factors, so that its intervals
    contain the true values in the worst group of drives of an independent simulator. They were
    measured once, with networks of an earlier training; no study makes them again. Coverage with
    the present networks and these factors: ``studies.other_code``.
    """
    known = json.loads((_HERE / "widening.json").read_text(encoding="utf-8")).get(family, {})
    return {int(motions): factors for motions, factors in known.items()}
