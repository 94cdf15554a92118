"""Simulate, train, infer, correct and judge without the workflow, in some 20 seconds of one core.

Lengths are in mm and times in ms. The network is smaller than the default one. After 300 steps it
is far from exact, but its draws are good enough to start the correction.
"""

from breaker.common.compiling import set_threads
from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.networks.training import Trainer
from breaker.paper.bank import simulate
from breaker.paper.calibration import judge_draws
from breaker.paper.correction import correct_validation, judge
from breaker.paper.inference import validate
from breaker.paper.posterior import Posterior
from breaker.paper.training import Rows, freeze_inputs, split
from breaker.paper.validation import summary

SUMMARY = {"kind": "time_series", "features": 32, "components": 16, "width": 64, "blocks": 1}
SUMMARY |= {"channels": [8], "kernels": [16], "strides": [16], "gru_width": 8}
SUMMARY |= {"skip": 3, "skip_width": 4}
INFERENCE = {"kind": "coupling_flow", "transforms": 3, "bins": 8, "hidden": [64]}

set_threads(1)  # small work: one thread is fastest
config = load()
settings = {"motion": "closing", "prior": config["prior"], "sensor": config["sensor"]}
posterior = Posterior(settings | {"network": {"summary": SUMMARY, "inference": INFERENCE}}, seed=1)

bank = simulate(posterior.model, 10000, generator(1, "bank"))
rows, validation = (bank.isel(curve=part) for part in split(10000, 500))
freeze_inputs(posterior, rows, generator(1, "components"))
rows, validation = Rows.of(rows, posterior), Rows.of(validation, posterior)
short = {"steps": 300, "batch": 128, "learning_rate": 0.006, "evaluate_every": 100}
Trainer(posterior, rows, validation, config["training"] | short, seed=1, ema=0.98).run()

records = validate(posterior.eval(), 24, draws=500, seed=2)  # 24 records with known truth
exact = correct_validation(posterior.model, records, seed=2)
print(summary(judge(posterior, records, exact), exact)[["gap_nats", "efficiency_median"]])
print("an output is not calibrated:", judge_draws(exact.draws, exact.truth).outside.any())
# posterior.save("closing.safetensors") writes the network; Posterior.load reads it. A file with
# functions of your own needs own_functions=True and runs them: read only files that you trust.
