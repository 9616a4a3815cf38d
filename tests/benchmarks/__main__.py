"""``python -m tests.benchmarks [part …]``: ratios, taken in one run on one machine; all parts if none is named."""

import argparse

import numpy as np

from tests.benchmarks import calibration, kinematics, lessons, live, pipeline, startup
from tests.benchmarks.timing import QUIET, computer, strain

MODULES = (kinematics, startup, pipeline, lessons, live, calibration)
PARTS = {part.__name__.rpartition(".")[2]: part for part in MODULES}


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description="How fast, as ratios.")
    parser.add_argument("parts", nargs="*", metavar="part", help=", ".join(PARTS))
    chosen = parser.parse_args().parts or list(PARTS)
    if unknown := set(chosen) - set(PARTS):
        parser.error(f"no part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    print(computer())
    busy, slowed = np.median([strain() for _ in range(10)], axis=0)
    print(f"busy {busy:.2f}, slowed {slowed:.2f} (1 is best; above {QUIET} a row has no verdict)")
    for name in chosen:
        PARTS[name].run()


if __name__ == "__main__":
    main()
