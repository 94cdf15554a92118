"""The configuration: complete, explained, and clear about what is wrong with it."""

import os
import re
from copy import deepcopy

import pytest
import yaml

from breaker.configuration import schema
from breaker.configuration.__main__ import main
from breaker.configuration.loading import (
    ConfigurationError,
    check,
    chosen_network,
    load,
    merge,
    read,
)
from breaker.configuration.rules import RULES
from breaker.configuration.schema import configuration_schema, derived
from breaker.configuration.yaml_sources import parse
from breaker.drive.family.mechanisms import MECHANISMS
from breaker.model.quantities import AFTER_RELEASE, ANSWERED, QUANTITIES
from breaker.networks.build import INFERENCE_NETWORKS, SUMMARY_NETWORKS, build
from breaker.reading.files.format_settings import READABLE
from breaker.shipped import DEFAULTS
from tests.networks_fixtures import built
from tests.workflow.conftest import ROOT, snakemake

STATED = [ROOT / "config" / name for name in ("advanced.yaml", "config.yaml")]
OVERLAYS = ["paper.yaml", "precise.yaml", "any.yaml", "test.yaml"]


@pytest.fixture
def complaint(tmp_path):
    """Returns the message about an overlay, given as text."""

    def message(text: str, *more: str) -> str:
        files = []
        for number, content in enumerate((text, *more)):
            files.append(tmp_path / f"overlay_{number}.yaml")
            files[-1].write_text(content, encoding="utf-8")
        with pytest.raises(ConfigurationError) as caught:
            load([DEFAULTS, *files])
        return str(caught.value)

    return message


def leaves(config: dict, above: tuple = ()) -> dict[tuple, object]:
    """Values by key, of everything that is not a section."""
    found = {}
    for name, value in config.items():
        section = isinstance(value, dict) and value  # one without keys is a value
        found |= leaves(value, (*above, name)) if section else {(*above, name): value}
    return found


def parts(part: dict, above: tuple = ()):
    """Yield every part of the schema with its key; entries of lists and choices have the key []."""
    yield above, part
    for name, inner in part.get("properties", {}).items():
        yield from parts(inner, (*above, name))
    for inner in (*filter(None, [part.get("items")]), *part.get("oneOf", ())):
        yield from parts(inner, (*above, "[]"))


# ---- what is in the repository


def test_defaults_are_valid():
    assert load([DEFAULTS])["seed"] == 1


def test_every_quantity_that_can_become_worse_has_its_advice():
    known = {*QUANTITIES, *MECHANISMS} - ANSWERED | {*AFTER_RELEASE.values()}
    advice = read(DEFAULTS)["advice"]
    assert {*advice} == known
    assert all(1 < len(words) < 130 for words in advice.values())


def test_a_configured_rate_is_one_that_is_read():
    schema = configuration_schema()["properties"]
    form = schema["endurance"]["properties"]["format"]["properties"]["rate"]
    assert (form["minimum"], form["maximum"]) == READABLE
    sensor = schema["rig"]["properties"]["sensor"]["properties"]["rate"]
    assert READABLE[0] <= sensor["minimum"] < sensor["maximum"] <= READABLE[1]


@pytest.mark.parametrize(
    ("stated", "default"), [({"a": {}, "b": {}}, {"a": 1}), ({"a": {}}, {"a": 1, "b": 2})]
)
def test_schema_and_defaults_have_the_same_keys(stated, default):
    assert set(leaves(read(DEFAULTS))) == set(schema.leaves(configuration_schema()))
    with pytest.raises(ConfigurationError, match=r"do not name the same settings: b\. State each"):
        derived({"section": stated}, {"section": default})


@pytest.mark.parametrize(
    ("stated", "default", "schema"),
    [
        ({}, True, {"type": "boolean"}),
        ({"range": [0, 9]}, 3, {"type": "integer", "minimum": 0, "maximum": 9}),
        ({"exclusiveMinimum": 0}, 3.0, {"type": "number", "exclusiveMinimum": 0}),
        ({"type": "number"}, 3, {"type": "number"}),
        ({"type": ["string", "null"], "maxLength": 9}, None, None),
        ({"enum": ["a", "b"]}, "a", None),
        (
            {"range": [0, 9]},
            [1.0, 2.0],
            {"type": "array", "minItems": 2, "maxItems": 2}
            | {"items": {"type": "number", "minimum": 0, "maximum": 9}},
        ),
    ],
)
def test_the_default_says_what_is_not_stated(stated, default, schema):
    assert derived(stated, default) == (schema or stated)


def test_every_missing_default_is_noticed():
    """Sections without any of their values: each is missed by its name."""

    def emptied(config):
        inner = {key: value for key, value in config.items() if isinstance(value, dict) and value}
        return {key: emptied(value) for key, value in inner.items()}

    defaults = read(DEFAULTS)
    found = dict(schema.problems(emptied(defaults), configuration_schema()))
    missing = [key for key, text in found.items() if text.startswith("is missing; it must be")]
    assert set(missing) == set(leaves(defaults))
    with pytest.raises(ConfigurationError):
        check(emptied(defaults))
    assert len(missing) > 150


# Their keys are the user's, or depend on the records.
OPEN = (("known",), ("endurance", "events"), ("limits_by_type",), ("contact_lag",))


def test_schema_explains_every_key_and_knows_no_others():
    for key, part in parts(configuration_schema()):
        assert {"enum", "type", "oneOf"} & set(part), key
        if key and key[-1] != "[]":
            assert part["description"].endswith("."), key
        if part.get("type") == "object":
            assert part["additionalProperties"] is False or key in OPEN, key


def test_a_default_stands_in_one_file():
    advanced, own = (set(leaves(read(file))) for file in STATED)
    assert not advanced & own


@pytest.mark.parametrize("file", STATED, ids=lambda file: file.name)
def test_every_default_has_a_comment(file):
    lines = file.read_text(encoding="utf-8").splitlines()
    bare = []
    for number, line in enumerate(lines):
        is_value = re.match(r" *[A-Za-z_]+: *[^ #&*]", line)
        if is_value and "#" not in line and not lines[number - 1].lstrip().startswith("#"):
            bare.append(line)
    assert bare == []


@pytest.mark.parametrize("name", OVERLAYS)
def test_overlays_are_valid_and_hold_only_what_differs(name):
    overlay = ROOT / "config" / name
    load([DEFAULTS, overlay])
    defaults = leaves(read(DEFAULTS))
    same = [key for key, value in leaves(read(overlay)).items() if defaults[key] == value]
    assert same == []


def test_every_number_list_and_text_is_bounded():
    """A magnitude that nobody means ends in a message, not in a traceback hours later."""
    for key, part in parts(configuration_schema()):
        kinds = {part["type"]} if isinstance(part.get("type"), str) else {*part.get("type", ())}
        if kinds & {"number", "integer"}:
            assert {"minimum", "exclusiveMinimum"} & set(part), key
            assert {"maximum", "exclusiveMaximum"} & set(part), key
        assert "maxItems" in part or "array" not in kinds, key
        assert "maxLength" in part or "string" not in kinds, key


# ---- merging


def test_an_overlay_of_one_motion_leaves_the_other_and_its_input_alone(tmp_path):
    before = read(DEFAULTS)
    steps = before["training"]["closing"]["steps"] + 1
    features = before["network"]["closing"]["summary"]["features"] + 1
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text(
        f"network: {{closing: {{summary: {{features: {features}}}}}}}\n"
        f"training: {{closing: {{steps: {steps}}}}}\n"
    )
    config = load([DEFAULTS, overlay])
    changed = {key for key, value in leaves(config).items() if leaves(before)[key] != value}
    assert changed == {
        ("network", "closing", "summary", "features"),
        ("training", "closing", "steps"),
    }


def test_merge_replaces_lists_and_values_and_changes_neither_argument():
    base, overlay = {"a": {"b": [1, 2], "c": 3}, "d": 4}, {"a": {"b": [5]}, "d": {"e": 6}}
    copies = deepcopy((base, overlay))
    assert merge(base, overlay) == {"a": {"b": [5], "c": 3}, "d": {"e": 6}}
    assert (base, overlay) == copies


# ---- the networks chosen


@pytest.mark.parametrize("summary_kind", SUMMARY_NETWORKS)
@pytest.mark.parametrize("inference_kind", INFERENCE_NETWORKS)
@pytest.mark.parametrize("overlays", [[], ["test.yaml"]])
def test_an_overlay_that_names_the_kinds_makes_every_network(
    tmp_path, summary_kind, inference_kind, overlays
):
    overlay = tmp_path / "kinds.yaml"
    kinds = {"summary": {"kind": summary_kind}, "inference": {"kind": inference_kind}}
    overlay.write_text(yaml.safe_dump({"network": {"closing": kinds}}))
    files = [DEFAULTS, *(ROOT / "config" / name for name in overlays), overlay]
    chosen = chosen_network(load(files)["network"]["closing"])
    found = built(build, chosen, samples=151, dims=8)
    assert [type(network) for network in found] == [
        SUMMARY_NETWORKS[summary_kind],
        INFERENCE_NETWORKS[inference_kind],
    ]


# ---- messages

WRONG = """
# unknown keys
sensor: {noise: 0.1}
    sensor.noise is not a known key. Did you mean sensor.noise_sd?
shards: 3
    shards is not a known key. Did you mean family.shards or bank.shards?
bank: {zzz: 3}
    bank.zzz is not a known key. Known here: shards, curves_per_shard, online
# networks
advice: {gama_a: grease}
    advice.gama_a is not a known key
network: {closing: {summary: {kind: lstm}}}
    kind is "lstm", but must be time_series
network: {closing: {summary: {channels: [8]}}}
    channels is not a known key. Did you mean network.closing.summary.time_series.channels?
network: {closing: {inference: {coupling_flow: {hidden: 64}}}}
    hidden is 64, but must be a list of 1 to 4 entries, each a whole number, at least 1 and
# types
seed: first
    seed is "first", but must be a whole number, at least 0
bank: {shards: 2.0}
    bank.shards is 2.0, but must be a whole number
bank:
    bank is empty, but must be a section
sensor: {stop: .inf}
    sensor.stop is Infinity, but must be a number, at least 1 and at most 10000
# ranges
sensor: {noise_sd: -0.1}
    sensor.noise_sd is -0.1, but must be a number, at least 0.0001 and at most 10
motions: []
    motions is [], but must be a list of 1 to 2 entries, none twice
motions: [closing, closing]
    motions is ["closing", "closing"]
# how YAML reads numbers
training: {closing: {learning_rate: 1e-3}}
    learning_rate is "1e-3"
    YAML reads 1e-3 as a text; write 0.001.
bank: {shards: '5'}
    YAML reads 5 as a text; write 5
training: {closing: {device: on}}
    device is true
# values and keys of other types
endurance: {curves: 2024-11-20, breaker: 12, phase: !!binary aGVsbG8=}
    endurance.curves is "2024-11-20", but must be a text or null (none)
    endurance.breaker is 12
    endurance.phase is "b'hello'", but must be a text
motions: [2024-11-20 10:00:00, !!set {closing}]
    motions[0] is "2024-11-20 10:00:00", but must be one of closing, opening
    motions[1] is "{'closing'}", but must be one of closing, opening.
endurance: {events: {2024-11-20: [f], 12: [f], oil: 2024-11-20}}
    endurance.events.2024-11-20 is not a known key: YAML reads a number or a date, not
    endurance.events[12] is not a known key
    endurance.events.oil is "2024-11-20", but must be a list
# lag of contacts
contact_lag: {closing: [0.1, 0], touch: [0.1, 0.2]}
    contact_lag has closing with the standard deviation 0, but must have one above 0.
    has touch, but can have closing and opening alone.
contact_lag: {opening: [0.1]}
    contact_lag.opening is [0.1], but must be a list of 2 entries
# limits
limits: [{name: a, motion: closing, upper: {touch: 1}}]
    limits[0].upper.touch is not a known key. Did you mean limits[0].upper.touch_time?
limits: [{name: a, motion: closed, uper: {f: 1}}]
    limits[0].motion is "closed", but must be one of closing, opening
    limits[0].uper is not a known key. Did you mean limits[0].upper?
limits: [{name: "a\\nb", motion: closing, upper: {f: 1}}]
    limits[0].name is "a\\nb"
limits: [{name: a; b, motion: closing, upper: {f: 1}}]
    limits[0].name is "a; b"
limits: [{name: a, of: change, upper: {stroke: +5 %}}, {name: b, lower: {f: 1}}]
    limits cannot be used. a: stroke
    b: '' is not a motion
limits: [{name: a, motion: closing}, {name: a, motion: opening, lower: {f: 1}}]
    a: there are two limits of this name. Give one another name.
    a: it has no quantity. Name one under upper or lower, with a value.
limits: [{name: a, motion: closing, lower: {f: 1}}]
motions: [opening]
    limits has no limit of opening (motions). Add one.
limits_by_type: {GL 314: {stroke: [1, 2]}, gl-314: {stroke: [1, 2]}}
    limits_by_type has GL 314 and gl-314, which are one type. Put both together.
limits_by_type: {GL 314: {closed stroke: [1, 2]}, B: {stoke: [1, 2]}, C: {stroke: [2, 1]}}
    limits_by_type cannot be used: GL 314: closed stroke: 'closed' is not a motion.
    B: stoke: stoke is not a quantity
    C: stroke: from 2 to 1 allows nothing or all.
limits_by_type: {GL 314: {stroke: 5}}
    limits_by_type.GL 314.stroke is 5, but must be a list of 2 entries
# keys that must fit each other
validation: {seed: 7, second_seed: 7}
    validation.second_seed is 7, which validation.seed is too
bank: {shards: 2, curves_per_shard: 50}
training: {opening: {batch: 60, validation_curves: 30, held_out_curves: 11}}
    bank has 100 curves (shards times curves_per_shard), but a training needs 101
training: {opening: {steps: 10, evaluate_every: 11}}
    training.opening.evaluate_every is 11, but must not exceed training.opening.steps (10)
network: {opening: {summary: {components: 152}}}
    network.opening.summary.components is 152, but must not exceed sensor.samples (151)
solver: {reference: 8, candidates: [4, 8]}
    solver.reference is 8, but must be more than any of solver.candidates (8)
validation: {curves: 100, judged_curves: 101}
    validation.judged_curves is 101, but must not exceed validation.curves (100). Lower it, or raise
correction: {draws: 500, smallest_size: 501}
    correction.smallest_size is 501, but must not exceed correction.draws (500)
correction: {round_draws: 300, fit_size: 301}
    correction.fit_size is 301, but must not exceed correction.round_draws (300)
planning: {operations: -1, service_cost: -1, failure_cost: 20, inspection_cost: -0.1}
    planning.operations is -1
    planning.service_cost is -1
    planning.inspection_cost is -0.1
planning: {service_cost: 0, failure_cost: 0, inspection_cost: 0}
    planning.service_cost is 0, so a service costs nothing and would always be due. State a cost
planning: {service_cost: 5, failure_cost: 2}
    planning.failure_cost is 2, not more than planning.service_cost (5): then no service pays.
planning: {inspection: 3 weeks}
    planning.inspection is "3 weeks"
planning: {inspection: 0 years}
    planning.inspection is "0 years", which is no interval of inspection
planning: {inspection: 2}
    planning.inspection is 2, but must be a text
rigs: {elements: {closing_stop: {reach: [2.0, 1.0]}}}
    rigs.elements closing_stop: reach is [2.0, 1.0], but the first must not exceed the second
family: {more: {drag: [0.2, 0.1]}}
    family.more drag is [0.2, 0.1], but the first must not exceed the second
family: {touch: [0.9, 0.5]}
    family.touch is [0.9, 0.5]
rigs: {wear: {parameters: [3, 2], elements: [0, 1]}}
    rigs.wear has parameters: [3, 2]
rigs: {wear: {parameters: [1, 2], elements: [0, 7]}}
    rigs.wear has elements: [0, 7]
# units, and what cannot be read
prior: {f: {median: 750.0}, L: {median: 0.010}}
    prior.f.median is 750, 1,000 times that of the reference drive at this size (0.75)
    prior.L.median is 0.01, 0.001 times that of the reference drive at this size (10)
prior: {k_b: {median: 2.5}, gamma_a: {median: 75.0}, gamma_b: {median: 30.0}}
size: {lengths: 10.0, times: 4.0}
    prior.k_b.median is 2.5, 1,000 times that of the reference drive at this size (0.0025)
    prior.gamma_a.median is 75, 1,000 times
    prior.gamma_b.median is 30, 1,000 times
prior: {f: {median: 0.03}}
    prior leaves the contact pressed (f > k_a L) in
endurance: {format: {time_column: null}}
    endurance.format cannot be used: endurance.format.time_column is null, so endurance.format.rate
endurance: {format: {encoding: base64}}
    endurance.format cannot be used: endurance.format.encoding: base64 is no encoding of text
sensor: {samples: 19}
    network.closing.summary.components is 24, but must not exceed sensor.samples (19)
known: {touch: [9.5, 0.1], L: [10.0, 0]}
    touch is not a quantity
    has L: [10.0, 0], which has the standard deviation 0
known: {mu: [2.4, 0.1]}
    known has mu, but no step of the workflow takes facts. Leave it empty, and give them to
endurance: {curves: nowhere}
    nowhere/closing/ has no file of a record
    nowhere/opening/ has no file of a record
endurance: {breaker: A}
    endurance.breaker is A, but the stand-in is one breaker
endurance: {curves: nowhere, events: {',': [f], Oil-ed: [f], 'gas, oil ed': [mu]}}
    endurance.events has ','
    has 'oil ed' in 'Oil-ed' and in 'gas, oil ed'
# sections of a life
wear_model: {reference: [300, 200]}
    wear_model.reference is [300, 200]
wear_model: {reference: first}
    wear_model.reference is "first"
"""
CASES = re.findall(r"((?:^[^\s#].*\n)+)((?:^    .*\n)+)", WRONG, re.MULTILINE)


@pytest.mark.parametrize(("overlay", "expected"), CASES)
def test_message_names_key_value_and_remedy(complaint, overlay, expected):
    message = complaint(overlay)
    for fragment in [*map(str.strip, expected.splitlines()), "overlay_0.yaml, line 1: "]:
        assert fragment in message
    assert "config/config.yaml or config/advanced.yaml" in message


def test_layers_and_sizes_that_just_fit_are_accepted(tmp_path):
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text(
        "network: {opening: {summary: {components: 151, time_series: {channels: [8, 8], "
        "kernels: [5, 5], strides: [2, 2], skip: 35}}}}\n"
        "bank: {shards: 2, curves_per_shard: 50}\n"
        "training:\n"
        "  closing: {batch: 60, validation_curves: 30, held_out_curves: 10}\n"
        "  opening: {batch: 60, validation_curves: 30, held_out_curves: 10}\n"
        "validation: {curves: 100, judged_curves: 100}\n"
        "correction: {draws: 500, smallest_size: 500, round_draws: 300, fit_size: 300}\n"
    )
    assert load([DEFAULTS, overlay])["bank"]["shards"] == 2


def test_every_rule_is_about_keys_that_exist():
    known = set(schema.leaves(configuration_schema()))
    sections = {key[:depth] for key in known for depth in range(1, len(key) + 1)}
    assert {tuple(key.split(".")) for keys, _ in RULES for key in keys} <= sections


def test_a_rule_is_silent_where_a_key_is_wrong_by_itself(complaint):
    message = complaint("bank: {shards: none}\nsensor: {samples: 3.5}")
    assert "2 problems" in message
    assert "bank has" not in message


def test_all_problems_are_listed_each_with_its_line(complaint):
    message = complaint("seed: -1\nsensor:\n  samples: 1\n  nois_sd: 0.2\n")
    for problem in ("line 1: seed", "line 3: sensor.samples", "line 4: sensor.nois_sd"):
        assert problem in message


def test_message_names_the_file_that_holds_the_value(complaint):
    message = complaint("seed: 5\nbank: {shards: 0}", "seed: -5")
    assert "overlay_0.yaml, line 2: bank.shards is 0" in message
    assert "overlay_1.yaml, line 1: seed is -5" in message
    with pytest.raises(ConfigurationError, match="\n  seed is -3"):  # without files the key alone
        check(merge(read(DEFAULTS), {"seed": -3}))


def test_a_key_that_stands_twice_is_noticed(complaint):
    message = complaint("sensor: {noise_sd: 0.2}\nbank:\n  shards: 5\n  shards: 6\nsensor: {}")
    assert "overlay_0.yaml, line 4: shards stands in line 3 already" in message
    assert "overlay_0.yaml, line 5: sensor stands in line 1 already" in message
    merged = "training:\n  closing: &its\n    steps: 9\n  opening:\n    <<: *its\n    steps: 8\n"
    merged += "    clip: 2\n    clip: 3"
    message = complaint(merged)
    assert "line 8: clip stands in line 7 already" in message
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
    assert load([DEFAULTS, one])["motions"] == ["closing"]


def test_each_row_of_a_folder_states_the_rate_that_the_configuration_lacks(complaint, tmp_path):
    (tmp_path / "1.csv").touch()
    table, head = tmp_path / "operations.csv", "file,motion,operation,rate\n1.csv,closing,1,10\n"
    table.write_text(head + "1.csv,closing,2,\n")
    overlay = f"endurance: {{curves: {tmp_path}, format: {{time_column: null}}}}\n"
    assert "endurance.format.rate is needed" in complaint(overlay + "motions: [closing]\n")
    table.write_text(head)
    (tmp_path / "my.yaml").write_text(overlay + "motions: [closing]\n")
    assert load([DEFAULTS, tmp_path / "my.yaml"])


@pytest.mark.parametrize(
    ("kind", "written"),
    [("number", text) for text in ("1e-3", "1E5", "-2e+3", "1.5e-07", ".5e3", "1e300")]
    + [("integer", text) for text in ("1e5", "2.5e+3")],
)
def test_the_remedy_for_a_number_is_a_number_to_yaml(kind, written):
    part = {"properties": {"key": {"type": kind}}}
    ((_, text),) = schema.problems({"key": written}, part)
    remedy = yaml.safe_load(re.search(r"; write (\S+)\.$", text)[1])
    assert remedy == float(written)
    assert list(schema.problems({"key": remedy}, part)) == []


@pytest.mark.parametrize(
    "content",
    [
        *(None, os.mkfifo, os.mkdir, "seed: [1", "- 1", "seed: 1\n---\nseed: 2"),
        *("\n# é".encode("latin-1"), "seed: 2".encode("utf-16"), "seed: 2001-13-01"),
        *("seed: !!int x", "seed: !!bool x", f"seed: {'9' * 5000}"),
        *("seed: !!python/object/apply:os.getpid []", "a: &a [*a]"),
        f"a: {'[' * 3000}{']' * 3000}",
    ],
    ids=range(15),
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    path = tmp_path / "mine.yaml"
    if callable(content):
        content(path)
    elif content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ConfigurationError, match=rf"^{path}: "):
        load([DEFAULTS, path])


def test_aliases_and_merges_as_they_are_meant_are_read(tmp_path):
    (tmp_path / "mine.yaml").write_text("a: &a {x: 1}\nb: *a\nc: {<<: *a, y: 2}")
    content, _ = parse(tmp_path / "mine.yaml")
    assert content == {"a": {"x": 1}, "b": {"x": 1}, "c": {"x": 1, "y": 2}}


def test_snakemake_names_each_key_and_shows_no_traceback(tmp_path):
    overlay = tmp_path / "mine.yaml"
    overlay.write_text("sensor: {noise_sd: -0.1}\nendurance: {curves: 2024-11-20}\n")
    given = ["--configfile", overlay, "--config", "sensor={noise: 0.1}", "seed=one"]
    output = snakemake("--dry-run", *given, "--", "all", fails=True)
    for key in ("sensor.noise is", "seed is", "sensor.noise_sd is -0.1", "endurance.curves is"):
        assert key in output
    assert "Traceback" not in output


def test_files_are_checked_by_a_command(tmp_path, capsys):
    overlay = tmp_path / "mine.yaml"
    overlay.write_text("seed: 2\nsensor: {noise_sd: -0.1}\n")
    assert main(str(ROOT / "config/test.yaml"), str(overlay)) == 1
    assert f"{overlay}, line 2: sensor.noise_sd is -0.1" in capsys.readouterr().err
    assert main(str(ROOT / "config/test.yaml")) == 0
    assert main() == 2
