"""Read and write the model files of a family, and compare them with a configuration.

Importing this module is fast: the plan of the workflow compares files without numpy.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from breaker.common.lazy_numpy import np
from breaker.common.tensor_file import ModelFileError, open_model, settings_of, write_model
from breaker.model.parameters import MOTIONS, NAMES
from breaker.shipped import FAMILIES, KINDS, model_file, widening

if TYPE_CHECKING:
    from breaker.family.networks import ChangeNetwork, StateNetwork


def header_of(config: Mapping[str, Any], kind: str, definition: Mapping) -> dict[str, Any]:
    """Return the header of a network of "levels" or "changes", of a family with a definition."""
    family = config["family"]
    # No weight depends on the number of workers.
    training = {name: value for name, value in family["training"].items() if name != "workers"}
    return {
        "kind": kind,
        "family": family["name"],
        "definition": definition,
        "bank": {key: family[key] for key in ("drives", "shards")},
        **{key: config[key] for key in ("seed", "prior")},
        "network": family["network"],
        "training": training,
    }


def unfit(path: str | Path, config: Mapping[str, Any], kind: str, definition: Mapping) -> list[str]:
    """Return differences of a network and a configuration in the prior and the family.

    Raises:
        FileNotFoundError: If the file does not exist.
        ModelFileError: If the file is not a model file.
    """
    both = settings_of(path), header_of(config, kind, definition)
    parts = [{key: one.get(key) for key in ("family", "definition", "prior")} for one in both]
    return differing(*parts)


def differing(found: Any, wanted: Any, key: str = "") -> list[str]:
    """Return the differences of settings, as ``key: found, not wanted``.

    Example:
        >>> differing({"seed": 1, "prior": {"f": 2}}, {"seed": 1, "prior": {"f": 3}})
        ['prior.f: 2, not 3']
    """
    if not (isinstance(found, Mapping) and isinstance(wanted, Mapping)):
        return [] if found == wanted else [f"{key}: {found}, not {wanted}"]
    lines = []
    for name in sorted(found.keys() | wanted.keys()):
        pair = (settings.get(name, "nothing") for settings in (found, wanted))
        lines += differing(*pair, f"{key}.{name}".removeprefix("."))
    return lines


def write_network(
    path: str | Path,
    settings: Mapping,
    weights: Mapping[str, np.ndarray],
    frozen: Mapping[str, object],
) -> None:
    """Write a network.

    Args:
        settings: What ``header_of`` returns.
        weights: Weights of ``training.FamilyNetwork``.
        frozen: Other arrays of ``StateNetwork`` or ``ChangeNetwork``: ``usual``, ``centre`` and
            ``scale``; and by motion ``bases``, ``change_bases`` and ``members``.
    """
    arrays = {f"network.{name}": np.float32(weight) for name, weight in weights.items()}
    for name, value in frozen.items():
        if not isinstance(value, Mapping):
            arrays[name] = np.float64(value)
            continue
        for motion, parts in value.items():
            for part, array in parts._asdict().items():
                arrays[f"{name}.{motion}.{part}"] = np.float64(array)
    write_model(path, settings, arrays)


def open_network(path: str | Path) -> StateNetwork | ChangeNetwork:
    """Read a network; ``shipped.widening`` widens the posterior draws of a state network.

    Raises:
        FileNotFoundError: If the file does not exist.
        ModelFileError: If the file is not that of a network of a family.
    """
    from breaker.family.inputs import Basis
    from breaker.family.membership import Membership
    from breaker.family.networks import EVENTS, ChangeNetwork, Network, StateNetwork
    from breaker.model.prior import Prior

    with open_model(path) as saved:
        kind = saved.settings.get("kind")
        if kind not in list(KINDS):
            raise ModelFileError("it is not a network of a family of drives")
        weights, arrays = {}, {}
        for name in saved.arrays:
            if name.startswith("network."):
                weights[name.removeprefix("network.")] = saved.weight(name, "float32")
            else:
                arrays[name] = saved.weight(name, "float64")
        Prior.from_settings(saved.settings["prior"])  # raises if the prior is not valid

        def by_motion(name: str, of: type) -> dict:
            parts = {m: [arrays[f"{name}.{m}.{part}"] for part in of._fields] for m in MOTIONS}
            return {motion: of(*values) for motion, values in parts.items()}

        parts = {name: arrays[name] for name in ("usual", "centre", "scale")}
        parts |= {"settings": saved.settings, "bases": by_motion("bases", Basis)}
        if kind == "changes":
            network = Network(weights, ChangeNetwork.atoms)
            change_bases = by_motion("change_bases", Basis)
            return ChangeNetwork(network=network, change_bases=change_bases, **parts)
        wider = {}
        for count, factors in widening(saved.settings["family"]).items():
            wider[count] = np.array([factors.get(name, 1.0) for name in (*NAMES, *EVENTS)])
        return StateNetwork(
            network=Network(weights, StateNetwork.atoms),
            members=by_motion("members", Membership),
            widening=wider,
            **parts,
        )


def shipped_networks(*kinds: str) -> Iterator[tuple[StateNetwork | ChangeNetwork, ...]]:
    """Yield the networks of each shipped family, of some kinds or all, and open them as needed."""
    for family in FAMILIES:
        yield tuple(_shipped(family, kind) for kind in kinds or KINDS)


def shipped_levels() -> Iterator[StateNetwork]:
    """Yield the shipped state networks, in the order in which families are tried."""
    return (state for (state,) in shipped_networks("levels"))


@cache
def _shipped(family: str, kind: str) -> StateNetwork | ChangeNetwork:
    return open_network(model_file(family, kind))
