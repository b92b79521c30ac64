"""Whether a result stands firm: how far it moves where three pixels in a hundred are a digit off.

Random laboratories with all defects at once are analysed as they were recorded, and once more with 1 DN added to or taken from
3 % of all pixels. That adds a thousandth or so to the variance of the noise, and should move a parameter by some hundredths of
its standard uncertainty. What moves farther hangs on a decision: a threshold, a number of knots.

    .venv/bin/python benchmarks/accuracy/continuity.py --rigs 20 --camera photon
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from irtiming.archive.frame_stack import ArrayFrames
from irtiming.errors import IrTimingError
from irtiming.measurement import analyse
from irtiming.records.recording import FrameStack, Recording
from irtiming.records.result import Result
from irtiming.twin.random_laboratory import Wanted, draw, recordings

SHARE = 0.03


def a_digit_off(stack: FrameStack, random: np.random.Generator) -> ArrayFrames:
    """The frames, some pixels of which have one digit more or less."""
    frames = stack.pick(list(range(stack.shape[0])))
    moved = (random.random(frames.shape) < SHARE) & (frames > 0) & (frames < frames.max())
    frames[moved] = frames[moved] + np.where(random.random(np.count_nonzero(moved)) < 0.5, 1, -1)
    return ArrayFrames(frames)


def disturbed(one: Recording, seed: int) -> Recording:
    return replace(one, frames=a_digit_off(one.frames, np.random.default_rng((20261127, seed))))


def moves(wanted: Wanted, seed: int) -> dict[str, float] | str:
    """How far each parameter moves, in standard uncertainties; or what was refused."""
    rig = draw(wanted, seed=seed)
    made = list(recordings(rig, wanted, seed=seed))
    try:
        first, second = (analyse(some, rig.measured).best for some in (made, [disturbed(one, seed) for one in made]))
    except IrTimingError as error:
        return str(error)
    return moved(first, second)


def moved(first: Result, second: Result) -> dict[str, float]:
    names = [name for name in first.estimate.names if name in second.estimate]
    return {name: (second.estimate.value(name) - first.estimate.value(name)) / first.estimate.u(name) for name in names}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--camera", choices=("photon", "microbolometer"), default="photon")
    parser.add_argument("--speeds", default="3", help="wheel rates of each rig, Hz, with commas between")
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--rows", type=int, default=60)
    parser.add_argument("--columns", type=int, default=80)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    rates = tuple(float(text) for text in options.speeds.split(","))
    wanted = Wanted(
        camera=options.camera, rows=options.rows, columns=options.columns, frames=options.frames, wheel_hz=rates
    )  # fmt: skip
    with ProcessPoolExecutor(options.workers) as pool:
        found = list(pool.map(partial(moves, wanted), range(options.rigs)))
    done = [one for one in found if not isinstance(one, str)]
    print("| parameter | laboratories | rms move, u | largest move, u |\n| --- | ---: | ---: | ---: |")
    for name in sorted({name for one in done for name in one}):
        size = np.abs([one[name] for one in done if name in one])
        print(f"| {name.replace('_', ' ')} | {size.size} | {np.sqrt(np.mean(size**2)):.3f} | {size.max():.3f} |")
    for seed, one in enumerate(found):
        if isinstance(one, str):
            print(f"seed {seed}: {one}")


if __name__ == "__main__":
    main()
