"""The launcher for a source checkout: `python cli.py render fire`."""

from gen_art.commands.main import main

main()
