"""Learn what the model leaves out from drives of a family that it does not fit."""

from breaker.mechanism import Size
from breaker.model import Prior, Sensor, generator
from breaker.stores import describe, save
from breaker.synthetic import Family, ensemble, learn
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params
chosen = dict(params.discrepancy)

sensor = Sensor.from_settings(params.sensor)
family = Family(Prior.from_settings(params.prior), params.rigs, Size(**params.size))
rng = generator(params.seed, "discrepancy")
drives = ensemble(family, sensor, params.motions, chosen.pop("drives"), rng)
learned = learn(drives, sensor, **chosen)
largest = abs(drives.delta.sel(condition="new")).max("time").median("drive")
for motion in params.motions:
    log.info(
        "%s: the model differs from a drive by %.2f mm at most (median of %d drives); components "
        "leave %.2g of the square of the differences",
        *(motion, largest.sel(motion=motion), drives.sizes["drive"]),
        learned.left.sel(motion=motion, condition="new"),
    )
names = ("motions", "prior", "sensor", "size", "rigs", "discrepancy")
settings = {name: params[name] for name in names}
learned = describe(learned, "what the model leaves out", **settings)
save(learned.assign_attrs(seed=params.seed), snakemake.output[0])
