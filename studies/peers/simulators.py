"""Curves per processor second of the exact mechanism beside ODE solvers, one core.

    python -m studies.peers.simulators --motion closing

Records of the default prior and sensor, random onsets included. Compilation does not count. The
error of a solver is its largest difference from the mechanism over all curves and samples; of the
tolerances tried, diffrax is shown with the fastest that keeps the error, and with all others.
"""

from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from breaker.common.randomness import generator
from breaker.mechanism.curves import rest_position, travel
from breaker.quantities.parameters import NAMES
from studies.peers.common import (
    CLOCKS,
    joint_model,
    parser,
    read_settings,
    restart,
    write_json,
)

_clock = CLOCKS["processor"]
_ACCURATE = 1e-4  # mm, a thousandth of the noise
_TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
_LANES = (32, 128)  # curves that diffrax solves together


def solve(theta: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Return the travel ``(t,)`` of one operation that starts at time 0, by ``solve_ivp``."""
    mu, k_a, k_b, gamma_a, gamma_b, f, gap = theta.tolist()
    pull = f if motion == "closing" else 0.0
    rest = float(rest_position(theta, motion))

    def free(_, y):
        x_a, v_a, x_b, v_b = y.tolist()
        spring = k_b * (x_b - x_a) + gamma_b * (v_b - v_a)
        return v_a, pull - k_a * x_a - gamma_a * v_a + spring, v_b, -mu * spring

    def closed(_, y):
        x_a, v_a, _, _ = y.tolist()
        spring = k_b * (gap - x_a) - gamma_b * v_a
        return v_a, pull - k_a * x_a - gamma_a * v_a + spring, 0.0, 0.0

    def reached(_, y):
        return gap - y[2] if motion == "closing" else k_b * (y[0] - gap) + gamma_b * y[1]

    reached.terminal, reached.direction = True, -1
    first, second = (free, closed) if motion == "closing" else (closed, free)
    start = [rest, 0.0, 0.0 if motion == "closing" else gap, 0.0]
    position = np.full(len(times), rest)
    moving = times > 0
    settings = {"rtol": 1e-6, "atol": 1e-8}
    run = solve_ivp(
        first, (0.0, times[-1]), start, t_eval=times[moving], events=reached, **settings
    )
    reported = len(run.t)  # a list where there is none
    found = run.y[0] if reported else np.empty(0)
    if run.status == 1:
        now, state = run.t_events[0][0], run.y_events[0][0]
        later = times[moving][reported:]
        state[2:] = gap, 0.0
        rerun = solve_ivp(second, (now, times[-1]), state, t_eval=later, **settings)
        found = np.concatenate([found, rerun.y[0]])
    position[moving] = found
    return position


def main() -> None:
    options = parser(__doc__.splitlines()[0], "simulators")
    options.add_argument("--curves", type=int, default=20_000, help="of the mechanism")
    options.add_argument("--solved", type=int, default=2048, help="of diffrax")
    options.add_argument("--stepped", type=int, default=200, help="of solve_ivp")
    given = options.parse_args()
    restart(given.threads, JAX_ENABLE_X64="1")

    model = joint_model(given.motion, read_settings())
    rng = generator(given.seed, "simulators", given.motion)
    theta = model.prior.sample(given.curves, rng)
    onset = model.sensor.onset_sd * rng.standard_normal(given.curves)
    times = model.sensor.times

    def mechanism(n: int) -> np.ndarray:
        return travel(theta[:n], times, given.motion, onset=onset[:n]).travel

    def stepped(n: int) -> np.ndarray:
        return np.array([solve(theta[k], times - onset[k], given.motion) for k in range(n)])

    mechanism(1)
    rows = [measure("breaker", "exact", mechanism, given.curves, mechanism, rounds=5)]
    rows.append(measure("scipy solve_ivp", "RK45, rtol 1e-6", stepped, given.stepped, mechanism))
    for method in ("Tsit5", "Dopri8"):
        for tolerance in _TOLERANCES:
            for lanes in _LANES:
                function = diffrax_solver(method, tolerance, lanes, theta, times, onset, given)
                name = f"{method}, rtol {tolerance:.0e}, {lanes} together"
                rows.append(measure("diffrax", name, function, given.solved, mechanism))
    accurate = [row for row in rows if row["tool"] == "diffrax" and row["error"] <= _ACCURATE]
    if accurate:
        max(accurate, key=lambda row: row["curves_per_second"])["chosen"] = True
    record = {"motion": given.motion, "accurate": _ACCURATE, "rows": rows}
    write_json(given.out, record)


def measure(tool: str, settings: str, function, n: int, exact, *, rounds: int = 3) -> dict:
    """Return speed and error of a function that simulates ``n`` curves; the median round counts."""
    function(min(n, 1024))  # compiles
    spent = []
    for _ in range(rounds):
        begin = _clock()
        found = function(n)
        spent.append(_clock() - begin)
    return {
        "tool": tool,
        "settings": settings,
        "curves": n,
        "curves_per_second": n / float(np.median(spent)),
        "error": float(np.abs(found - exact(n)).max()),
    }


def diffrax_solver(method: str, tolerance: float, lanes: int, theta, times, onset, given):
    """Return a function that simulates the first ``n`` curves by diffrax, ``lanes`` at a time."""
    import jax

    batched = jax.jit(jax.vmap(partial(_curve, method, tolerance, given.motion, times)))

    def simulate(n: int) -> np.ndarray:
        starts = range(0, n, lanes)
        parts = [np.asarray(batched(theta[i : i + lanes], onset[i : i + lanes])) for i in starts]
        return np.concatenate(parts)[:n]

    return simulate


def _curve(method: str, tolerance: float, motion: str, times, theta, onset):
    """Travel ``(t,)`` of one operation: to the event, from there on, at rest before the onset."""
    import diffrax
    import jax.numpy as jnp
    import optimistix

    mu, k_a, k_b, gamma_a, gamma_b, f, gap = (theta[i] for i in range(len(NAMES)))
    closing = motion == "closing"
    pull = f if closing else 0.0
    rest = 0.0 if closing else (f + k_b * gap) / (k_a + k_b)

    def free(t, y, _):
        spring = k_b * (y[2] - y[0]) + gamma_b * (y[3] - y[1])
        forward = pull - k_a * y[0] - gamma_a * y[1] + spring
        return jnp.stack([y[1], forward, y[3], -mu * spring])

    def closed(t, y, _):
        spring = k_b * (gap - y[0]) - gamma_b * y[1]
        still = jnp.zeros_like(y[0])
        return jnp.stack([y[1], pull - k_a * y[0] - gamma_a * y[1] + spring, still, still])

    def margin(t, y, args, **_):
        return gap - y[2] if closing else k_b * (y[0] - gap) + gamma_b * y[1]

    first, second = (free, closed) if closing else (closed, free)
    solver = getattr(diffrax, method)()
    steps = diffrax.PIDController(rtol=tolerance, atol=tolerance)
    ts = jnp.maximum(times - onset, 0.0)
    end = ts[-1]
    start = jnp.stack([rest + 0.0 * f, 0.0 * f, (0.0 if closing else 1.0) * gap, 0.0 * f])
    saved = diffrax.SaveAt(subs=[diffrax.SubSaveAt(ts=ts), diffrax.SubSaveAt(t1=True)])
    event = diffrax.Event(margin, optimistix.Newton(tolerance * 1e-2, tolerance * 1e-2))
    # An event of one curve among many is taken for a failure; what fails shows in its error.
    options = {"stepsize_controller": steps, "max_steps": 16384, "throw": False}
    run = diffrax.diffeqsolve(
        diffrax.ODETerm(first), solver, 0.0, end, 0.1, start, saveat=saved, event=event, **options
    )
    now, state = run.ts[1][0], run.ys[1][0]
    state = jnp.stack([state[0], state[1], gap, 0.0 * gap])
    later = jnp.maximum(ts, now)
    saved = diffrax.SaveAt(ts=later)
    end = jnp.maximum(end, now + 1e-9)
    rerun = diffrax.diffeqsolve(
        diffrax.ODETerm(second), solver, now, end, 0.1, state, saveat=saved, **options
    )
    position = jnp.where(ts <= now, run.ys[0][:, 0], rerun.ys[:, 0])
    return jnp.where(times <= onset, rest, position)


if __name__ == "__main__":
    main()
