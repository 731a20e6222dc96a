"""Reproduce the paper: fly Section 6 as published, and see where its certificate fails.

Prints the figures of the flight and the entries of the paper's Section 4 beside what is true, and
writes the paper's Figures 2 and 3 to the folder given (default: output/paper).
"""

import sys
from pathlib import Path

from uav_tracking_mpc.cli.main import main

if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "output/paper")
    code = main(["simulate", "--config", "paper", "--output", str(folder)])
    print(f"Figures 2 and 3: {folder / 'trajectory.png'}, {folder / 'states.png'}")
    sys.exit(code or main(["stability", "--config", "paper", "--output", str(folder)]))
