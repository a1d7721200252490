"""`python -m lingual.app` is the `lingual` command."""

from .command_line import main

main()
