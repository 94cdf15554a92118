"""`python -m breaker`: the command `breaker`, where its script is not on the path."""

import sys

from breaker.cli import main

if __name__ == "__main__":
    sys.exit(main())
