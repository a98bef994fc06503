"""The program: signals are handled before anything else is loaded."""

import sys

from tuner.stop import INTERRUPTED, heed, interrupt, say_interrupted


def main() -> None:
    """Run the command line."""
    heed(interrupt)
    try:
        from tuner.cli import main as run

        run()
    except KeyboardInterrupt:
        say_interrupted()
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()
