"""The program: signals are handled before anything else is loaded."""

from tuner.stop import end, heed, heed_the_lost, interrupt, number_of


def main() -> None:
    """Run the command line."""
    heed(interrupt)
    heed_the_lost()
    try:
        from tuner.cli import main as run

        run()
    except KeyboardInterrupt as stopped:
        end(number_of(stopped))


if __name__ == "__main__":
    main()
