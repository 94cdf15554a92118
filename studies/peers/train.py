"""Train one tool on a bank within a budget of processor time on one core.

    python -m studies.peers.train --tool sbi_npe --motion closing --seconds 600 --out DIR

A short warm-up in the same process finds the number of steps that fits; the training then starts
anew, with its schedules over that number. The budget is spent on all that follows the reading of
the bank: set-up, compilation, steps, validations.
"""

from pathlib import Path

from studies.peers.common import (
    RESULTS,
    clock,
    joint_model,
    one_core,
    parser,
    plan,
    read_bank,
    read_settings,
    truth,
    write_json,
)
from studies.peers.tools import TOOLS, environment, make


def main() -> None:
    options = parser(__doc__.splitlines()[0])
    options.add_argument("--tool", choices=TOOLS, required=True)
    options.add_argument("--bank", type=Path, help="folder of shards (results/bank/MOTION)")
    options.add_argument("--seconds", type=float, default=600.0, help="processor time to train")
    options.add_argument("--out", type=Path, help=f"folder ({RESULTS}/MOTION/TOOL)")
    given = options.parse_args()
    one_core(given.core, **environment(given.tool))

    out = given.out or RESULTS / given.motion / given.tool
    settings = read_settings()
    bank = read_bank(given.bank or Path("results/bank") / given.motion, settings)
    tool = make(given.tool)
    run = runner(tool, bank, settings, given)

    planned = plan(run, given.seconds, unit=tool.unit)
    begin = clock()
    trained = run(planned["steps"])
    seconds = clock() - begin
    out.mkdir(parents=True, exist_ok=True)
    tool.save(out)
    record = {
        "tool": given.tool,
        "motion": given.motion,
        "seed": given.seed,
        "budget": given.seconds,
        "settings": tool.settings(),
        "plan": planned,
        "seconds": seconds,
        "curves_per_second": trained["curves"] / seconds,
        **trained,
    }
    write_json(out / "training.json", record)
    print(record)


def runner(tool, bank, settings: dict, given):
    """Return the function that trains a tool for so many steps, from nothing."""
    if hasattr(tool, "train_on"):
        return lambda steps: tool.train_on(bank, given.motion, steps, given.seed)
    model = joint_model(given.motion, settings)
    travel, z = bank.travel.values, truth(bank, model)
    return lambda steps: tool.train(travel, z, model.sensor, steps, given.seed)


if __name__ == "__main__":
    main()
