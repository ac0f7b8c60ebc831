"""`python -m gen_art`."""

from gen_art.commands.main import main

main()
