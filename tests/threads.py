"""The same script on other numbers of threads."""

import os
import subprocess
import sys

THREADS = (1, 2, 4)


def digests(script: str) -> list[str]:
    """What a script prints on 1, 2 and 4 threads, a number that it reads from sys.argv[1]."""
    return [
        subprocess.run(
            [sys.executable, "-c", script, str(n)], capture_output=True, text=True, env=dict(os.environ), check=True
        ).stdout
        for n in THREADS
    ]
