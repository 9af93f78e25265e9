"""A child of `mutated_inputs` that crashes, or hangs, as it is told."""

import os
import sys

if __name__ == "__main__":
    if sys.argv[2] == "crash":
        os.abort()
    while True:
        pass
