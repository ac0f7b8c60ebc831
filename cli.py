"""The launcher for a source checkout: `python cli.py render fire`."""

from gen_art.commands.main import main

if __name__ == "__main__":  # the worker processes of `gen-art sweep --workers` import this file
    main()
