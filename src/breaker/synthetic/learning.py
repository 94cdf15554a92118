"""What the model leaves out, learned from drives of a family: a Gaussian of few components.

For every drive, delta is the difference of its curve from the model's curve *at the drive's true
parameters*, both without noise and with the same onset. With z the standardised parameters,

``delta_new = mean + z slopes + a basis``,   ``delta_worn - delta_new = (dz) slopes + b basis``,

where mean and slopes are a regression over all new drives, the basis has the components in which
the residuals of both lines are largest (in the metric of a record's noise and zero), and a, b and
the change ``dz`` of the parameters of both motions together have joint second moments. A family is
finite and a Gaussian has thin tails, so a and b are widened by a factor.

The *lag*, by which a drive's contact touches or parts after the model's, is learned of new drives
along with delta: a regression on z, and one of what it leaves on a.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, travel
from breaker.model import Sensor
from breaker.synthetic.family import Family

__all__ = ["ensemble", "learn"]

_EXAMPLES = 20  # drives whose differences are kept to be drawn


def ensemble(
    family: Family, sensor: Sensor, motions: Sequence[str], n: int, rng: np.random.Generator
) -> xr.Dataset:
    """Draw drives, new and worn, and return how the model at their parameters differs from them.

    Args:
        sensor: Grid and onset of the records.
        motions: Motions of each drive; each has its own onset, the same new and worn.

    Returns:
        Dataset over ``condition`` (new, worn), ``motion``, ``drive``, ``time`` and ``parameter``:
        the drives' curves without noise, ``travel``, and ``delta``, both mm; standardised
        parameters ``z``; ``onset``, ms; and ``lag``, ms, by which a drive's contact touches for the
        first time, or parts, after the model's: nan if either does not.
    """
    new = [family.new(rng) for _ in range(n)]
    drives = [new, [family.worn(drive, rng) for drive in new]]
    onset = sensor.onset_sd * rng.standard_normal((len(motions), n))
    theta = np.array([[drive.theta for drive in condition] for condition in drives])
    curves = np.empty((2, len(motions), n, sensor.samples))
    delta, lag = np.empty_like(curves), np.empty(curves.shape[:3])
    for c, condition in enumerate(drives):
        for m, motion in enumerate(motions):
            for i, drive in enumerate(condition):
                curves[c, m, i], lag[c, m, i] = drive.operate(motion, sensor.times - onset[m, i])
            exact = travel(theta[c], sensor.times, motion, onset=onset[m])
            delta[c, m] = curves[c, m] - exact.travel
            both = np.isfinite(lag[c, m]) & np.isfinite(exact.switching)
            lag[c, m] = np.where(both, lag[c, m], np.nan) - exact.switching
    everything = ("condition", "motion", "drive", "time")
    return xr.Dataset(
        {
            "travel": (everything, curves, {"unit": "mm"}),
            "delta": (everything, delta, {"unit": "mm"}),
            "z": (("condition", "drive", "parameter"), family.prior.standardise(theta)),
            "onset": (("motion", "drive"), onset, {"unit": "ms"}),
            "lag": (everything[:3], lag, {"unit": "ms"}),
        },
        coords={
            "condition": ["new", "worn"],
            "motion": list(motions),
            "time": ("time", sensor.times, {"unit": "ms"}),
            "parameter": list(NAMES),
        },
    )


def learn(drives: xr.Dataset, sensor: Sensor, *, components: int, widening: float) -> xr.Dataset:
    """Learn the Gaussian of what the model leaves out.

    Args:
        drives: ``delta``, ``z`` and ``lag`` of an ``ensemble``.
        sensor: Noise and zero, in whose metric components are compared.
        components: Components of each motion, c.
        widening: Factor of the standard deviations of a and b.

    Returns:
        Dataset over ``motion``, ``time``, ``parameter``, ``component``: ``mean``, ``slopes``,
        ``basis`` and ``factor`` (the components of a, each scaled to its standard deviation,
        largest first), mm; ``spread (motion, condition, time)``, the sd of delta of a new drive
        about ``mean``, and the root of the mean square of its change with wear, mm; ``left (motion,
        condition)``, the share of the whitened residuals' square beyond the components; of the lag
        ``lag_mean``, ``lag_slopes``, ``lag_loading`` (by component of the factor) and ``lag_sd``
        (what is left), ms; ``covariance (state, other_state)``, second moments of the change of z,
        of a for each motion, and of b for each motion; and ``examples``, delta of a few drives, mm.
    """
    z_new, z_worn = drives.z.values
    change = z_worn - z_new
    moments, scores = [], {"a": [], "b": []}
    for motion in drives.motion.values:
        new, worn = drives.delta.sel(motion=motion).values
        found, a, b = _one_motion(z_new, change, new, worn - new, sensor, components)
        a, b = widening * a, widening * b
        slopes, basis = found["slopes"], found["basis"]
        draws = [z_new @ slopes + a @ basis, change @ slopes + b @ basis]
        found["spread"] = np.sqrt([np.square(each).mean(0) for each in draws])
        lag = _lag(drives.lag.sel(motion=motion).values[0], z_new, a, widening)
        moments.append(found | {"factor": _factor(a) @ basis} | lag)
        scores["a"].append(a)
        scores["b"].append(b)
    state = np.hstack([change, *scores["a"], *scores["b"]])
    dims = {
        "mean": ("motion", "time"),
        "slopes": ("motion", "parameter", "time"),
        **dict.fromkeys(("basis", "factor"), ("motion", "component", "time")),
        "spread": ("motion", "condition", "time"),
        "left": ("motion", "condition"),
        "lag_mean": ("motion",),
        "lag_slopes": ("motion", "parameter"),
        "lag_loading": ("motion", "component"),
        "lag_sd": ("motion",),
    }
    data = {name: (dims[name], np.stack([each[name] for each in moments])) for name in dims}
    data["covariance"] = (("state", "other_state"), state.T @ state / len(state))
    data["examples"] = drives.delta.isel(drive=slice(_EXAMPLES)).astype(np.float32).drop_attrs()
    pairs = [(kind, motion) for kind in "ab" for motion in drives.motion.values]
    names = [f"{kind} {motion} {k + 1}" for kind, motion in pairs for k in range(components)]
    return xr.Dataset(data, coords={"state": [*(f"change {name}" for name in NAMES), *names]})


def _one_motion(
    z: np.ndarray,
    change: np.ndarray,
    new: np.ndarray,
    worn: np.ndarray,
    sensor: Sensor,
    components: int,
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """Regression, basis, and share of the square beyond it, of one motion; and its a and b.

    Shapes: ``z`` and ``change`` ``(n, p)``, ``new`` and its change ``worn`` ``(n, t)``.
    """
    columns = np.column_stack([np.ones(len(z)), z])
    mean, *slopes = np.linalg.lstsq(columns, new, rcond=None)[0]
    residuals = new - mean - z @ slopes, worn - change @ slopes
    whiten = sensor.noise_and_zero.whiten(np.eye(sensor.samples))  # symmetric
    whitened = [each @ whiten for each in residuals]
    directions = np.linalg.svd(np.vstack(whitened), full_matrices=False)[2][:components]
    a, b = (each @ directions.T for each in whitened)
    whole = np.array([np.square(each).sum() for each in whitened])
    kept = np.array([np.square(each).sum() for each in (a, b)])
    found = {
        "mean": mean,
        "slopes": np.array(slopes),
        "basis": np.linalg.solve(whiten, directions.T).T,
        "left": np.divide(whole - kept, whole, out=np.zeros(2), where=whole > 0),
    }
    return found, a, b


def _factor(scores: np.ndarray) -> np.ndarray:
    """Return F with ``F.T @ F`` the second moments of scores ``(n, c)``, ``(c, c)``, by size."""
    _, sizes, directions = np.linalg.svd(scores / np.sqrt(len(scores)), full_matrices=False)
    return sizes[:, None] * directions


def _lag(lag: np.ndarray, z: np.ndarray, a: np.ndarray, widening: float) -> dict[str, np.ndarray]:
    """Moments of the lag ``(n,)``, given parameters ``(n, p)`` and widened scores a, ``(n, c)``.

    What the regression on z leaves is widened as well. The loading is by xi, ``a = xi F``.
    """
    there = np.isfinite(lag)
    lag, z, xi = lag[there], z[there], a[there] @ np.linalg.pinv(_factor(a))
    (mean, *slopes), *_ = np.linalg.lstsq(np.column_stack([np.ones(len(z)), z]), lag)
    left = widening * (lag - mean - z @ slopes)
    loading, *_ = np.linalg.lstsq(xi, left)
    free = max(1, len(z) - z.shape[1] - 1 - xi.shape[1])
    sd = np.sqrt(np.square(left - xi @ loading).sum() / free)
    return {"lag_mean": mean, "lag_slopes": np.array(slopes), "lag_loading": loading, "lag_sd": sd}
