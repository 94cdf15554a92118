"""Networks of a family in model files, which hold all that an answer needs."""

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from breaker.common.tensor_file import ModelFileError, open_model, write_model
from breaker.drive.family.change_network import Changes
from breaker.drive.family.level_network import EVENTS, Levels
from breaker.drive.family.membership import Membership
from breaker.drive.family.network_inputs import Basis
from breaker.drive.family.trained_network import Network
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.reading.records.normalised_shape import SHAPE_TIMES
from breaker.shipped import FAMILIES, KINDS, model_file, widening

_KINDS = {"levels": Levels, "changes": Changes}
_OTHER = "it is damaged, or of another version of breaker"
_TUPLES = {"bases": Basis, "change_bases": Basis, "members": Membership}
_BASIS = {"directions": "b g", "mean": "g", "variances": "b"}
_MEMBERS = {"noise": "l", "squares": "l k", "shares": "k", "left": "l 3"}
_PARTS = {
    "levels": {"bases": _BASIS, "members": _MEMBERS},
    "changes": {"bases": _BASIS, "change_bases": _BASIS},
}
_LAYERS = {"summary.enter": "w i", "summary.leave": "s w", "inference.head": "t s"}
_LAYERS |= {"inference.project": "p s"}
_ARRAYS = {"centre": "q", "scale": "q", "usual": "2 2", "network.inference.bias": "q o"}
_ARRAYS |= {"network.inference.enter": "q r h", "network.inference.leave": "q h o"}


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
        weights: Those of ``network_training.FamilyNetwork``.
        frozen: What ``Levels`` or ``Changes`` have beside the network: ``usual``, ``centre``,
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


def open_network(path: str | Path) -> Levels | Changes:
    """Read a network; draws of levels are as wide as ``shipped.widening`` says for its family.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is no file of a network of a family.
    """
    with open_model(path) as saved:
        kind = saved.settings.get("kind")
        if kind not in [*_KINDS]:
            raise ModelFileError("it is no network of a family of drives")
        _check_shapes(saved.shapes, kind)
        weights, arrays = {}, {}
        for name in saved.shapes:
            if name.startswith("network."):
                weights[name.removeprefix("network.")] = saved.weight(name, "float32")
            else:
                arrays[name] = saved.weight(name, "float64")
        try:
            Prior.from_settings(saved.settings["prior"])
            network = Network(weights, _KINDS[kind].atoms)
            found = {name: arrays[name] for name in ("usual", "centre", "scale")}
            for name, parts in _PARTS[kind].items():
                found[name] = {
                    m: _TUPLES[name](**{part: arrays[f"{name}.{m}.{part}"] for part in parts})
                    for m in MOTIONS
                }
            if kind == "levels":
                names, factors = (*NAMES, *EVENTS), widening(saved.settings["family"])
                found["widening"] = {
                    n: np.array([of.get(name, 1.0) for name in names]) for n, of in factors.items()
                }
            return _KINDS[kind](settings=saved.settings, network=network, **found)
        except (KeyError, TypeError, ValueError) as error:
            raise ModelFileError.of_settings(error) from error


def _check_shapes(shapes: Mapping[str, tuple[int, ...]], kind: str) -> None:
    """Refuse tensors that do not fit together: their names, dimensions, and sizes."""
    blocks = (sum(name.startswith("network.summary.inner.") for name in shapes) + 1) // 2
    within = {f"summary.{of}.{k}": "w w" for of in ("inner", "outer") for k in range(blocks)}
    wanted = dict(_ARRAYS)
    for name, dims in (_LAYERS | within).items():
        wanted[f"network.{name}.weight"] = dims
        wanted[f"network.{name}.bias"] = dims.split()[0]
    for name, parts in _PARTS[kind].items():
        for motion in MOTIONS:
            own = {"b": f"{name}.{motion}"}
            for part, dims in parts.items():
                wanted[f"{name}.{motion}.{part}"] = " ".join(own.get(d, d) for d in dims.split())
    if odd := sorted(wanted.keys() ^ shapes.keys()):
        what = "is missing" if odd[0] in wanted else "is not known"
        raise ModelFileError(f"its tensor {odd[0]} {what}; {_OTHER}")
    q = len(_KINDS[kind].atoms)
    sizes = {"2": 2, "3": 3, "g": SHAPE_TIMES.size, "q": q, "r": 2 * q, "t": q * (q + 3) // 2}
    for name, dims in wanted.items():
        found, asked = shapes[name], dims.split()
        pairs = zip(asked, found, strict=False)
        fits = len(asked) == len(found) and all(n and sizes.setdefault(d, n) == n for d, n in pairs)
        if not fits or ("p" in sizes and sizes["p"] != q * sizes["h"]):
            what = f"its tensor {name}, of {' x '.join(map(str, found))}, does not fit the others"
            raise ModelFileError(f"{what}; {_OTHER}")


def shipped_networks(*kinds: str) -> Iterator[tuple[Levels | Changes, ...]]:
    """Yield the networks of each family that ships, of some kinds or all; each is opened when asked
    for.
    """
    for family in FAMILIES:
        yield tuple(_kept(family, kind) for kind in kinds or KINDS)


def shipped_levels() -> Iterator[Levels]:
    """Yield the networks of levels that ship, as families are tried."""
    return (levels for (levels,) in shipped_networks("levels"))


@cache
def _kept(family: str, kind: str) -> Levels | Changes:
    return open_network(model_file(family, kind))
