"""The configuration: complete, bounded, and clear about what is wrong with it."""

import re
from functools import reduce
from operator import getitem

import pytest
import yaml

from breaker.configuration.data_files import advice_of
from breaker.configuration.loading import (
    ConfigurationError,
    check,
    defaults,
    load,
    of_motion,
    read,
)
from breaker.family.networks import EFFECTS
from breaker.model.quantities import AFTER_RELEASE, ANSWERED, QUANTITIES
from breaker.networks.summary import INFERENCE_NETWORKS, build
from tests.networks_fixtures import built
from tests.scripts import script
from tests.workflow.conftest import ROOT, snakemake

MOST = 140  # settings
OVERLAYS = ["paper.yaml", "precise.yaml", "any.yaml", "test.yaml"]
SCHEMA = script("envs/defaults.py").schema()


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


def leaves(section: dict, above: tuple = ()):
    """Yield the key of every value; an empty section is a value."""
    for name, value in section.items():
        inner = isinstance(value, dict) and value
        yield from leaves(value, (*above, name)) if inner else [(*above, name)]


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


# ---- every setting is explained, bounded, and refuses what is wrong


@pytest.mark.parametrize("key", [key for key, _ in parts(SCHEMA)], ids=".".join)
def test_a_wrong_value_or_key_is_refused_by_name(key):
    part, name = dict(parts(SCHEMA))[key], ".".join(key)
    assert re.fullmatch(r"\S.*\.", part["description"])
    for kind in [part, *part.get("anyOf", ())]:
        if kind.get("type") in ("number", "integer") and "const" not in kind and "enum" not in kind:
            assert {"minimum", "exclusiveMinimum"} & set(kind)
            assert {"maximum", "exclusiveMaximum"} & set(kind)
    config = defaults()
    section = reduce(getitem, key[:-1], config)
    section[f"{key[-1]}_"], section[key[-1]] = 1, object()
    with pytest.raises(ConfigurationError) as caught:
        check(config)
    assert f"{name} " in str(caught.value)
    assert f"{name}_ is not a known key" in str(caught.value)


# ---- messages: an overlay, and what stands in the message

WRONG = """
by_motion: {closing: {network: {summary: {featurs: 1}}}}
    by_motion.closing.network.summary.featurs is not a known key
model: {simulator: mine}
    model.simulator is "mine": must be module:function
# how YAML reads numbers and texts
training: {learning_rate: 1e-3}
    training.learning_rate is "1e-3": must be a valid number
bank:
    bank is null: must be a valid dictionary
sensor: {stop: .inf}
    sensor.stop
motions: [closing, closing]
    motions is
endurance: {format: {ratio: 1,3}}
    endurance.format[3] is not a known key: Write numbers with a point, such as 1.3
# limits
limits: [{name: a, motion: closing, lower: {closing_speed: fast}, upper: 36 ms, tolerance: mm}]
    limits[0].lower.closing_speed is "fast"
    limits[0].upper is "36 ms": must be quantities with values
    limits[0].tolerance is "mm"
limits: [{name: a, motion: closing, lower: {closing_speed: 1300 mm/s}}]
    limits[0] cannot be used: closing_speed is 1300 mm/s
    m/s
limits: [{name: a, motion: closing, of: record, lower: {closing velocity: 1}}]
    limits[0] cannot be used
    closing_speed
limits: [{name: a, motion: closing, lower: {f: 1}}, {name: a, motion: opening, lower: {f: 1}}]
    limits has a name twice
limits: [{name: a, motion: closing, lower: {f: 1}}]
motions: [opening]
    limits has no limit of opening
limits: [{name: loose, of: change, lower: {k_b: -20 %}}, {name: a, motion: closing, lower: {f: 1}}]
    limits[0] has loose
    a measured quantity
speeds: {closing_speed: [6 mm, touch]}
    speeds is
# settings that must fit each other
bank: {shards: 2, curves_per_shard: 50}
    bank has 100 curves
planning: {service_cost: 5, failure_cost: 2}
    planning.failure_cost is 2
family: {drives: 60, training: {validation_curves: 20, held_out_curves: 40}}
    family.drives is 60
prior: {f: {median: 0.44}}
    prior has medians f 0.44 and k_a L 0.45
# files
bank: {shards: 5, shards: 6}
    the key shards stands twice
endurance: {curves: nowhere}
    endurance.curves cannot be used: nowhere has no table
"""
CASES = re.findall(r"((?:^[^\s#].*\n)+)((?:^    .*\n)+)", WRONG, re.MULTILINE)


@pytest.mark.parametrize(("overlay", "expected"), CASES)
def test_message_names_file_key_value_and_what_is_allowed(complaint, overlay, expected):
    message = complaint(overlay)
    for fragment in [*map(str.strip, expected.splitlines()), "overlay_0.yaml: "]:
        assert fragment in message


def test_all_problems_of_all_files_are_listed(complaint):
    message = complaint("seed: 5\nsensor:\n  samples: 1\n  nois_sd: 0.2\n", "seed: -5")
    for problem in ("sensor.samples is 1", "sensor.nois_sd", "seed is -5", "1.yaml: 3"):
        assert problem in message


def test_a_section_may_change_what_it_takes_from_another_one(tmp_path):
    text = "training: &its {steps: 9}\nby_motion:\n  closing:\n    training:\n      <<: *its\n"
    (tmp_path / "own.yaml").write_text(f"{text}      steps: 8\n")
    assert load([tmp_path / "own.yaml"])["by_motion"]["closing"]["training"]["steps"] == 8


def test_the_table_of_a_folder_of_curves_is_looked_into(complaint, tmp_path):
    folder, one = tmp_path / "mine", tmp_path / "one.yaml"
    folder.mkdir()
    (folder / "1.csv").touch()
    overlay = f"endurance: {{curves: {folder}}}\n"
    assert "operations.csv" in complaint(overlay)
    rows = "file,motion,operation,event\n1.csv,closing,1,danced\n"
    (folder / "operations.csv").write_text(rows, encoding="utf-8")
    assert "no operation of motion opening" in complaint(overlay)
    overlay += "motions: [closing]\n"
    assert "endurance.events lacks danced" in complaint(overlay)
    overlay = overlay.replace("}", ", events: {danced: [f]}}")
    types = tmp_path / "types.yaml"
    types.write_text("{}")
    one.write_text(overlay)
    assert load([one])["motions"] == ["closing"]
    assert "types is for a fleet" in complaint(f"{overlay}types: {types}\n")


# ---- files


@pytest.mark.parametrize(
    "content", [b"seed: [1", b"- 1", b"# \xe9", b"seed: !!python/object/apply:os.getpid []"]
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    with pytest.raises(ConfigurationError, match=rf"^{path}: "):
        load([path])
    with pytest.raises(FileNotFoundError, match=r"gone\.yaml"):
        load([tmp_path / "gone.yaml"])


def test_snakemake_names_each_key_and_shows_no_traceback(tmp_path):
    overlay = tmp_path / "mine.yaml"
    overlay.write_text("sensor: {noise_sd: -0.1}\n")
    given = ["--configfile", overlay, "--config", "sensor={noise: 0.1}", "seed=one"]
    output = snakemake("--dry-run", *given, "--", "all", fails=True)
    for key in ("sensor.noise is", "seed is", "sensor.noise_sd is -0.1"):
        assert key in output
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("limit: {}", ["GL 314.limit is not a known key"]),
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
