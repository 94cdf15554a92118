"""Networks of a family in model files, which hold all that an answer needs."""

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from breaker.common.tensor_file import ModelFileError, open_model, write_model
from breaker.family.inputs import Basis
from breaker.family.membership import Membership
from breaker.family.networks import EVENTS, ChangeNetwork, Network, StateNetwork
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.shipped import FAMILIES, KINDS, model_file, widening

_KINDS = {"levels": StateNetwork, "changes": ChangeNetwork}
_TUPLES = {"bases": Basis, "change_bases": Basis, "members": Membership}
_PARTS = {
    "levels": ("bases", "members"),
    "changes": ("bases", "change_bases"),
}


def write_network(
    path: str | Path,
    settings: Mapping,
    weights: Mapping[str, np.ndarray],
    frozen: Mapping[str, object],
) -> None:
    """Write a network.

    Args:
        settings: ``kind``, "levels" or "changes", ``family``, its name, ``prior``, that of drives
            of size 1, and how it was made.
        weights: Those of ``training.FamilyNetwork``.
        frozen: Arrays of ``StateNetwork`` or ``ChangeNetwork`` as arrays: ``usual``, ``centre``,
            ``scale``, and by motion ``bases``, ``change_bases`` and ``members``.
    """
    arrays = {f"network.{name}": np.float32(each) for name, each in weights.items()}
    for name, each in frozen.items():
        if name not in _TUPLES:
            arrays[name] = np.float64(each)
            continue
        for motion, parts in each.items():
            for part, value in parts._asdict().items():
                arrays[f"{name}.{motion}.{part}"] = np.float64(value)
    write_model(path, settings, arrays)


def open_network(path: str | Path) -> StateNetwork | ChangeNetwork:
    """Read a network; draws of levels are as wide as ``shipped.widening`` says for its family.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is no file of a network of a family.
    """
    with open_model(path) as saved:
        kind = saved.settings.get("kind")
        if kind not in [*_KINDS]:
            raise ModelFileError("it is no network of a family of drives")
        weights, arrays = {}, {}
        for name in saved.arrays:
            if name.startswith("network."):
                weights[name.removeprefix("network.")] = saved.weight(name, "float32")
            else:
                arrays[name] = saved.weight(name, "float64")
        Prior.from_settings(saved.settings["prior"])
        network = Network(weights, _KINDS[kind].atoms)
        found = {name: arrays[name] for name in ("usual", "centre", "scale")}
        for name in _PARTS[kind]:
            of = _TUPLES[name]
            found[name] = {
                m: of(*(arrays[f"{name}.{m}.{part}"] for part in of._fields)) for m in MOTIONS
            }
        if kind == "levels":
            names, factors = (*NAMES, *EVENTS), widening(saved.settings["family"])
            found["widening"] = {
                n: np.array([of.get(name, 1.0) for name in names]) for n, of in factors.items()
            }
        return _KINDS[kind](settings=saved.settings, network=network, **found)


def shipped_networks(*kinds: str) -> Iterator[tuple[StateNetwork | ChangeNetwork, ...]]:
    """Yield the networks of each family that ships, of some kinds or all; each is opened when asked
    for.
    """
    for family in FAMILIES:
        yield tuple(_kept(family, kind) for kind in kinds or KINDS)


def shipped_levels() -> Iterator[StateNetwork]:
    """Yield the networks of levels that ship, as families are tried."""
    return (levels for (levels,) in shipped_networks("levels"))


@cache
def _kept(family: str, kind: str) -> StateNetwork | ChangeNetwork:
    return open_network(model_file(family, kind))
