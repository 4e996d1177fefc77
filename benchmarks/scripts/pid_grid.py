"""The best PID for the table bha-control: a grid of gains, on robots for tuning.

./bha shell python -m benchmarks.scripts.pid_grid --robots 8

For each pair of gains: on how many robots it is stable with both doubled, and if on all, the median
time until all nine lengths stay within 2 mm and until their root mean square error does, and the
overshoot, over ten steps on every robot. It takes about three minutes on two cores.
"""

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from statistics import mean, median

import numpy as np

from benchmarks.trunk.length_control_methods import Pid
from benchmarks.trunk.length_responses import is_stable, new_plant, reachable, steps

PROPORTIONAL = (1e5, 2e5, 3e5, 4e5, 5e5, 6e5)  # [Pa/m]
INTEGRAL = (0.8e6, 1.2e6, 1.6e6, 2e6, 2.5e6, 3e6)  # [Pa/(m s)]

Told = dict[str, list[float]]


def try_pairs(seed: int) -> list[Told | None]:
    """Tell of every pair how steps of robot `seed` go; None where twice the gain is not stable."""
    plant = new_plant(seed)
    goals = reachable(plant, 11, np.random.default_rng([seed, 2]))
    start, told = plant.save_state(), []
    for proportional, integral in product(PROPORTIONAL, INTEGRAL):
        plant.restore_state(start)
        stable = is_stable(plant, partial(Pid, 2.0 * proportional, 2.0 * integral), goals[:4])
        plant.restore_state(start)
        told.append(steps(plant, Pid(proportional, integral), goals) if stable else None)
    return told


def main() -> None:
    """Print a line for every pair."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=8, help="robots 0 to this one")
    robots = parser.parse_args().robots
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        runs = list(pool.map(try_pairs, range(robots)))
    print("proportional  integral   stable  all nine [s]  rms [s]  overshoot [mm]: largest, mean")
    for index, (proportional, integral) in enumerate(product(PROPORTIONAL, INTEGRAL)):
        stable = [run[index] for run in runs if run[index] is not None]
        line = f"{proportional:12.0e} {integral:9.1e}  {len(stable):2d} of {robots}"
        if len(stable) == robots:
            values = {key: [x for told in stable for x in told[key]] for key in stable[0]}
            line += (
                f"{median(values['all within']):14.2f} {median(values['rms within']):8.2f}"
                f"{median(values['overshoot']):17.2f} {mean(values['mean overshoot']):5.2f}"
            )
        print(line)


if __name__ == "__main__":
    main()
