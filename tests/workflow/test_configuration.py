"""The configuration: complete, bounded, and clear about what is wrong with it."""

import os
import re
import sys
from functools import reduce
from operator import getitem

import pytest
import yaml

from breaker.configuration.checking import leaves
from breaker.configuration.definitions import advice_of, family_of, of_drive
from breaker.configuration.loading import (
    ConfigurationError,
    check,
    defaults,
    load,
    merge,
    of_motion,
    read,
)
from breaker.family.networks import EFFECTS
from breaker.model.quantities import AFTER_RELEASE, ANSWERED, QUANTITIES
from breaker.networks.summary import INFERENCE_NETWORKS, build
from breaker.shipped import FAMILIES, HELD_BACK, family_file
from tests.networks_fixtures import built
from tests.scripts import script
from tests.workflow.conftest import ROOT, snakemake

MOST = 140  # settings
OVERLAYS = ["paper.yaml", "precise.yaml", "any.yaml", "test.yaml"]
SCHEMA = script("envs/defaults.py").schema()
FREE = {"events", "known", "by_motion", "speeds", "advice"}


def problems_of(config) -> str:
    with pytest.raises(ConfigurationError) as caught:
        check(config)
    return str(caught.value)


@pytest.fixture
def complaint(tmp_path):
    """Returns the message about overlays, given as texts."""

    def message(*texts: str) -> str:
        files = []
        for number, content in enumerate(texts):
            files.append(tmp_path / f"overlay_{number}.yaml")
            files[-1].write_text(content, encoding="utf-8")
        with pytest.raises(ConfigurationError) as caught:
            load(files)
        return str(caught.value)

    return message


def parts(part: dict, above: tuple = ()):
    """Yield every setting of the schema, with its key."""
    for name, inner in part.get("properties", {}).items():
        if "properties" in inner:
            yield from parts(inner, (*above, name))
        else:
            yield (*above, name), inner


# ---- what is in the repository


def test_the_defaults_are_valid_and_few():
    check(defaults())
    assert len([*leaves(defaults())]) <= MOST


def test_every_quantity_that_can_become_worse_has_its_advice():
    known = {*QUANTITIES, *EFFECTS} - ANSWERED | {*AFTER_RELEASE.values()}
    assert {*advice_of()} == known
    assert all(1 < len(words) < 130 for words in advice_of().values())
    assert advice_of({"f": "ours"})["f"] == "ours"


@pytest.mark.parametrize("name", OVERLAYS)
def test_overlays_are_valid_and_hold_only_what_differs(name):
    overlay, usual = ROOT / "config" / name, defaults()
    load([overlay])
    for key in leaves(read(overlay)):
        value = reduce(getitem, key, read(overlay))
        if key[0] != "by_motion":
            assert reduce(getitem, key, usual) != value, key


# ---- merging


@pytest.mark.parametrize("kind", INFERENCE_NETWORKS)
def test_one_motion_has_settings_of_its_own(tmp_path, kind):
    own = {"network": {"inference": {"kind": kind}}, "training": {"steps": 500}}
    (tmp_path / "own.yaml").write_text(yaml.safe_dump({"by_motion": {"closing": own}}))
    config = load([tmp_path / "own.yaml"])
    closing, opening = (of_motion(config, motion) for motion in ("closing", "opening"))
    assert (closing["training"]["steps"], opening["training"]["steps"]) == (500, 2850)
    assert opening["network"]["inference"]["kind"] == defaults()["network"]["inference"]["kind"]
    _, inference = built(build, closing["network"], samples=151, dims=8)
    assert type(inference) is INFERENCE_NETWORKS[kind]


# ---- every setting refuses what is wrong


def numbers(part: dict):
    """Yield every part of a setting that may be a number, a text or a list."""
    yield part
    for inner in (*part.get("anyOf", ()), *filter(None, [part.get("items")])):
        yield from numbers(inner)


def beyond(part: dict):
    """Return a value out of the bounds of a setting."""
    for one in numbers(part):
        if "enum" in one or "const" in one:
            continue
        if one.get("type") in ("number", "integer"):
            assert {"minimum", "exclusiveMinimum"} & set(one)
            value = one.get("maximum", one.get("exclusiveMaximum")) * 2 + 1
            return int(value) if one["type"] == "integer" else float(value)
        if one.get("type") == "string":
            return "x" * (one["maxLength"] + 1)
    return "none of these"


@pytest.mark.parametrize("key", [key for key, _ in parts(SCHEMA)], ids=".".join)
def test_a_wrong_value_or_type_is_refused_by_name(key):
    """And each setting is explained."""
    part, name = dict(parts(SCHEMA))[key], ".".join(key)
    assert re.fullmatch(r"\S.*\.", part["description"])
    free = key[-1] in FREE
    for value in (object(), {"no such key": object()} if free else beyond(part)):
        config = defaults()
        reduce(getitem, key[:-1], config)[key[-1]] = value
        assert name in problems_of(config)
    config = defaults()
    section = reduce(getitem, key[:-1], config)
    section[f"{key[-1]}_"] = section[key[-1]]
    message = problems_of(config)
    assert f"{name}_ is not a known key" in message
    assert f"Did you mean {name}" in message


# ---- messages: an overlay, and what stands in the message

WRONG = """
shards: 3
    shards is not a known key. Did you mean bank.shards or family.shards?
by_motion: {closing: {network: {summary: {featurs: 1}}}}
    by_motion.closing.network.summary.featurs
    Did you mean network.summary.features?
model: {simulator: mine}
    model.simulator
# how YAML reads numbers and texts
training: {learning_rate: 1e-3}
    training.learning_rate is "1e-3"
    write 0.001.
bank: {shards: '5'}
    write 5.
sensor: {noise_sd: '0.20'}
    --config
    write 0.2.
bank:
    bank is empty
sensor: {stop: .inf}
    sensor.stop
motions: [closing, closing]
    motions is
endurance: {curves: 2024-11-20, breaker: 12}
    Quote it: "2024-11-20".
    Quote it: "12".
endurance: {events: {2024-11-20: [f], 12: [f], oil: 2024-11-20}}
    endurance.events[12] is not a known key
    endurance.events.oil
# limits
limits: [{name: a, motion: closed, uper: {f: 1}}]
    limits[0].motion is "closed"
    Did you mean limits[0].upper?
limits: [{name: a, motion: closing}, {name: a, motion: opening, lower: {f: 1}}]
    limits[0]
    limits has 'a'
limits: [{name: a, motion: closing, max: {f: 1}, lower: {closing_speed: 1,3, stroke: '1,3'}}]
    Did you mean limits[0].upper?
    1.3.
    stroke is "1,3"
limits: [{name: a, motion: closing, lower: {closing_speed: 1.3 m/s}, tolerance: 3 mm}]
    limits[0].lower.closing_speed is "1.3 m/s", but must be a number in m/s. Or it must be a perc
    limits[0].tolerance is "3 mm"
limits: [{name: a, motion: closing, of: record, lower: {closing velocity: 1}}]
    closing_speed
limits: [{name: a, motion: closing, lower: {f: 1}}]
motions: [opening]
    limits has no limit of opening
limits: [{name: loose, of: change, lower: {k_b: -20 %}}, {name: a, motion: closing, lower: {f: 1}}]
    limits[0] has loose
    a measured quantity
speeds: {closing_speed: [6 mm, touch]}
    speeds is
limits: [{name: a, of: change, lower: {f: half}}]
known: {lower: [stroke, 1]}
    limits[0].lower.f is "half", but must be a number in %
    known.lower[0] is "stroke"
known: {touch: [9.5, 0.1], L: [10.0, 0]}
    known.L is [10.0, 0]
# settings that must fit each other
bank: {shards: 2, curves_per_shard: 50}
    bank has 100 curves
network: {summary: {components: 152}}
    network.summary.components is 152
validation: {curves: 100, judged_curves: 101}
    validation.judged_curves is 101, but must not exceed curves (100)
planning: {service_cost: 5, failure_cost: 2}
    planning.failure_cost is 2
family: {drives: 60, training: {validation_curves: 20, held_out_curves: 40}}
    family.drives is 60
# units, and what cannot be read
prior: {f: {median: 750.0}, L: {median: 0.010}}
    prior.f.median is 750
    prior.L.median is 0.01
prior: {k_b: {median: 2.5}}
size: {lengths: 10.0, times: 4.0}
    prior.k_b.median is 2.5, 1,000 times
prior: {f: {median: 0.44}}
    prior has medians f 0.44 and k_a L 0.45
endurance: {format: {time_column: null}}
    endurance.format cannot be used
    endurance.format.rate
endurance: {curves: nowhere}
    nowhere/closing/
    nowhere/opening/
endurance: {breaker: A}
    endurance.breaker needs endurance.curves
endurance: {curves: nowhere, events: {',': [f], Oil-ed: [f], 'gas, oil ed': [mu]}}
    endurance.events has ','
    endurance.events has 'gas, oil ed'
"""
CASES = re.findall(r"((?:^[^\s#].*\n)+)((?:^    .*\n)+)", WRONG, re.MULTILINE)


@pytest.mark.parametrize(("overlay", "expected"), CASES)
def test_message_names_file_line_key_value_and_remedy(complaint, overlay, expected):
    message = complaint(overlay)
    for fragment in [*map(str.strip, expected.splitlines()), "overlay_0.yaml, line 1: "]:
        assert fragment in message
    assert "pattern" not in message


def test_all_problems_are_listed_each_with_its_file_and_line(complaint):
    message = complaint("seed: 5\nsensor:\n  samples: 1\n  nois_sd: 0.2\n", "seed: -5")
    places = ("0.yaml, line 3: sensor.samples", "0.yaml, line 4: sensor.nois_sd")
    for problem in (*places, "1.yaml, line 1: seed is -5", "configuration: 3"):
        assert problem in message
    assert "\n  seed is -3" in problems_of(merge(defaults(), {"seed": -3}))  # without files
    assert "bank has" not in complaint("bank: {shards: none}\nsensor: {samples: 3}")


def test_a_key_that_stands_twice_is_noticed(complaint):
    message = complaint("sensor: {noise_sd: 0.2}\nbank:\n  shards: 5\n  shards: 6\nsensor: {}")
    assert "overlay_0.yaml, line 4: shards stands in line 3 already" in message
    assert "overlay_0.yaml, line 5: sensor stands in line 1 already" in message
    merged = "training: &its {steps: 9}\nby_motion:\n  closing:\n    training:\n      <<: *its\n"
    merged += "      steps: 8\n      batch: 2\n      batch: 3"
    message = complaint(merged)
    assert "line 8: batch stands in line 7 already" in message
    assert "steps stands" not in message  # a section may change what it takes from another one


def test_a_folder_of_curves_is_looked_into(complaint, tmp_path):
    (tmp_path / "mine" / "closing").mkdir(parents=True)
    (tmp_path / "mine" / "closing" / "1.csv").touch()
    overlay = f"endurance: {{curves: {tmp_path / 'mine'}}}\n"
    message = complaint(overlay)
    assert f"{tmp_path / 'mine' / 'opening'}/" in message
    assert f"{tmp_path / 'mine' / 'closing'}/" not in message
    one = tmp_path / "one.yaml"
    one.write_text(overlay + "motions: [closing]\n")
    assert load([one])["motions"] == ["closing"]


# ---- files


@pytest.mark.parametrize(
    "content",
    [
        *(None, os.mkfifo, "seed: [1", "- 1", "seed: 1\n---\nseed: 2", "\n# é".encode("latin-1")),
        *("seed: 2001-13-01", "seed: !!int x", f"seed: {'9' * 5000}"),
        *("seed: !!python/object/apply:os.getpid []", "a: &a [*a]", f"a: {'[' * 3000}{']' * 3000}"),
    ],
    ids=range(12),
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    path = tmp_path / "mine.yaml"
    if callable(content):
        content(path)
    elif content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ConfigurationError, match=rf"^{path}: "):
        load([path])


def test_snakemake_names_each_key_and_shows_no_traceback(tmp_path):
    overlay = tmp_path / "mine.yaml"
    overlay.write_text("sensor: {noise_sd: -0.1}\nendurance: {curves: 2024-11-20}\n")
    given = ["--configfile", overlay, "--config", "sensor={noise: 0.1}", "seed=one"]
    output = snakemake("--dry-run", *given, "--", "all", fails=True)
    for key in ("sensor.noise is", "seed is", "sensor.noise_sd is -0.1", "endurance.curves is"):
        assert key in output
    assert "Traceback" not in output


@pytest.mark.parametrize("name", [*FAMILIES, HELD_BACK])
def test_a_family_of_ones_own_is_checked_by_key(tmp_path, name):
    own = tmp_path / "own.yaml"
    own.write_text(family_file(name).read_text(encoding="utf-8"))
    assert family_of(str(own)) == family_of(name)
    own.write_text(own.read_text().replace("  drag:", "  drog:").replace("reach: [", "reach: [9, "))
    with pytest.raises(ConfigurationError) as caught:
        family_of(str(own))
    for word in (str(own), "drog", "closing_stop"):
        assert word in str(caught.value)


OWN = """
import numpy as np
from breaker.model.parameters import NAMES

class Prior:
    names = ("a", "b")

    def sample(self, n, rng):
        return rng.random((n, 2)) + 1.0

class Loose:
    names = NAMES

    def sample(self, n, rng):
        medians = [2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0]  # 0.2 % of draws have f < k_a L
        return medians * np.exp(0.1 * rng.standard_normal((n, 7)))

def broken():
    raise RuntimeError("boom")

def simulate(theta, times, motion, rng):
    return theta[:, :1] * np.ones_like(times)

def short(theta, times, motion, rng):
    return theta
"""


@pytest.mark.parametrize(
    ("prior", "simulator", "good"),
    [
        ("Prior", "simulate", True),
        ("Loose", None, False),
        ("Prior", None, False),  # the drive of the paper has other parameters
        ("broken", "simulate", False),
        ("Prior", "short", False),
        ("Prior", "nothing", False),
    ],
)
def test_functions_of_ones_own_are_tried_before_the_first_job(
    tmp_path, monkeypatch, prior, simulator, good
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "own", raising=False)
    (tmp_path / "own.py").write_text(OWN, encoding="utf-8")
    model = {"prior": f"own:{prior}", "simulator": simulator and f"own:{simulator}"}
    mine = tmp_path / "my.yaml"
    mine.write_text(yaml.safe_dump({"model": model, "sensor": {"onset_sd": 0.0}}))
    assert load([mine], curves=False)["model"] == model  # as commands on records do
    assert "own" not in sys.modules
    if good:
        assert load([mine])["model"] == model
    else:
        with pytest.raises(ConfigurationError, match=r"my.yaml, line \d+: model.\w+ is own:"):
            load([mine])


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("limit: {}", ["GL 314.limit", "GL 314.limits"]),
        ("limits: {stroke: [178 cm, null]}", ["GL 314.limits", "stroke is 178 cm", "mm"]),
        ("speeds: {closing_speed: [6 s, touch]}", ["GL 314.speeds"]),
        ("{}\ngl-314: {}", ["GL 314 and gl-314"]),
    ],
)
def test_a_wrong_entry_of_a_type_is_named_by_file_and_key(complaint, tmp_path, entry, words):
    file = tmp_path / "types.yaml"
    file.write_text(f"GL 314:\n  {entry}\n", encoding="utf-8")
    message = complaint(f"types: {file}")
    for word in ("types.yaml", *words):
        assert word in message


def test_the_workflow_takes_the_entry_of_its_drives_type(tmp_path):
    """Of one breaker, by the column of its table; a fleet is left as it is."""
    types = tmp_path / "types.yaml"
    entry = (
        "limits: {stroke: [1, 9]}, ratio: 2.0, speeds: {closing_speed: [10 ms before touch, touch]}"
    )
    types.write_text(f"GL 314: {{{entry}}}\nLTB: {{}}\n", encoding="utf-8")
    rows = ["a.csv,closing,1,A,GL314", "a.csv,closing,2,A,gl-314", "b.csv,closing,1,B,LTB"]
    table = "\n".join(["file,motion,operation,breaker,type", *rows, ""])
    (tmp_path / "operations.csv").write_text(table, encoding="utf-8")
    about = {"curves": str(tmp_path), "breaker": "A"}
    config = merge(defaults(), {"types": str(types), "endurance": about})
    laid = of_drive(config)
    assert laid["endurance"] == merge(config["endurance"], {"format": {"ratio": 2.0}})
    assert laid["speeds"]["closing_speed"] == ["10 ms before touch", "touch"]
    own = [item["pair"] for item in laid["limits"][len(config["limits"]) :]]
    assert {*own} == {"closing stroke by type", "opening stroke by type"}
    for other in ({"types": None}, {"endurance": about | {"breaker": None}}):
        assert of_drive(merge(config, other)) == merge(config, other)
    (tmp_path / "operations.csv").write_text(table.replace("gl-314", "LTB"), encoding="utf-8")
    with pytest.raises(ConfigurationError, match="several types"):
        of_drive(config)
