"""Entry point of ``python -m nvcore``: the command line."""

from nvcore.cli import main

if __name__ == "__main__":
    main()
