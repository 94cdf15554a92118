"""Priors and draws in programs of others, and tables that they read: by the real packages.

They are of the studies' environment; without one of them its tests are left out.
"""

import csv
import json

import numpy as np
import pytest

from breaker.common.data_package import DescribedTable, data_package
from breaker.mechanism.evaluation import evaluate
from breaker.mechanism.probabilistic_programs import prior_in_numpyro, prior_in_pymc, theta_of
from breaker.quantities.parameters import NAMES

pytestmark = pytest.mark.filterwarnings("default")  # of the packages of others


@pytest.fixture
def loose(prior):
    """A prior of which the condition cuts a good part away."""
    return type(prior)(prior.medians, np.full(len(NAMES), 0.6))


@pytest.fixture
def points(loose):
    """Parameters inside of the prior's support, and outside."""
    inside = loose.sample(20, np.random.default_rng(1))
    outside = inside.copy()
    outside[:, NAMES.index("f")] = (
        0.5 * outside[:, NAMES.index("k_a")] * outside[:, NAMES.index("L")]
    )
    return np.vstack([inside, outside])


def assert_draws_are_of(prior, theta):
    """Means of logarithms, and how often the weaker half of the springs is drawn."""
    z = prior.standardise(theta)
    exact = prior.standardise(prior.sample(200_000, np.random.default_rng(2)))
    error = np.sqrt(2.0 * exact.var(axis=0) / (len(theta) / 10))  # of draws that are alike
    assert np.all(np.abs(z.mean(axis=0) - exact.mean(axis=0)) < 5.0 * error)
    assert prior.supported(theta).all()
    assert np.isfinite(evaluate(["touch_time"], theta[:50], "closing")).any()


def test_a_prior_in_pymc(loose, points):
    pymc = pytest.importorskip("pymc")
    with pymc.Model() as model:
        found = prior_in_pymc(loose)
    assert list(found) == list(NAMES)
    values = {model.rvs_to_values[found[name]]: name for name in NAMES}
    density = model.compile_logp(jacobian=False)
    logs = [
        density({v.name: np.log(row[NAMES.index(name)]) for v, name in values.items()})
        for row in points
    ]
    exact = loose.log_prob(points)
    assert np.array_equal(np.isfinite(logs), np.isfinite(exact))
    there = np.isfinite(exact)
    assert there.sum() == 20
    assert np.allclose(np.array(logs)[there], exact[there], rtol=1e-9)


def test_draws_of_pymc(loose):
    pymc = pytest.importorskip("pymc")
    with pymc.Model():
        prior_in_pymc(loose)
        start = dict(zip(NAMES, loose.sample(1, np.random.default_rng(4))[0], strict=True))
        found = pymc.sample(
            1000, tune=500, chains=2, cores=1, random_seed=1, initvals=start, progressbar=False
        )
    assert_draws_are_of(loose, theta_of(found.posterior))


def test_a_prior_in_numpyro(loose, points):
    pytest.importorskip("numpyro")
    import jax
    from numpyro.infer.util import log_density

    with jax.enable_x64(True):
        logs = [
            float(
                log_density(prior_in_numpyro, (loose,), {}, dict(zip(NAMES, row, strict=True)))[0]
            )
            for row in points
        ]
    exact = loose.log_prob(points)
    assert np.array_equal(np.isfinite(logs), np.isfinite(exact))
    there = np.isfinite(exact)
    assert np.allclose(np.array(logs)[there], exact[there], rtol=1e-9)


def test_draws_of_numpyro(loose):
    pytest.importorskip("numpyro")
    import jax
    from numpyro.infer import MCMC, NUTS, init_to_value

    start = dict(zip(NAMES, loose.sample(1, np.random.default_rng(4))[0], strict=True))
    kernel = NUTS(prior_in_numpyro, init_strategy=init_to_value(values=start))
    chain = MCMC(kernel, num_warmup=500, num_samples=2000, progress_bar=False)
    chain.run(jax.random.PRNGKey(1), loose)
    assert_draws_are_of(loose, theta_of(chain.get_samples()))


@pytest.fixture
def package(tmp_path):
    """A package of one table, in a folder below."""
    file = tmp_path / "endurance" / "closing.csv"
    file.parent.mkdir()
    with file.open("w", newline="", encoding="utf-8") as stream:
        rows = [["operation", "left", "fits", "note"], [1, "inf", True, ""], [2, "", False, "ö, ="]]
        csv.writer(stream).writerows(rows)
    columns = {"operation": "number", "left": "operations left", "fits": "whether", "note": "words"}
    found = data_package(tmp_path, "a run", [DescribedTable(file, "operations", columns)])
    target = tmp_path / "datapackage.json"
    target.write_text(json.dumps(found), encoding="utf-8")
    return target


def test_the_package_of_tables_is_valid(package, monkeypatch):
    frictionless = pytest.importorskip("frictionless")
    monkeypatch.chdir(package.parent)
    report = frictionless.validate(package.name)
    assert report.valid, report.flatten(["rowNumber", "fieldName", "message"])
    [rows] = [each.read_rows() for each in frictionless.Package(package.name).resources]
    assert [row["fits"] for row in rows] == [True, False]
    assert rows[1]["left"] is None


@pytest.mark.parametrize("fault", ["a changed file", "another type", "no such file"])
def test_a_package_that_is_not_true_is_told(package, monkeypatch, fault):
    frictionless = pytest.importorskip("frictionless")
    monkeypatch.chdir(package.parent)
    table = package.parent / "endurance" / "closing.csv"
    if fault == "a changed file":
        table.write_text(table.read_text(encoding="utf-8") + "3,1,True,\n", encoding="utf-8")
    elif fault == "another type":
        text = package.read_text(encoding="utf-8").replace('"string"', '"boolean"')
        package.write_text(text, encoding="utf-8")
    else:
        table.unlink()
    assert not frictionless.validate(package.name).valid
