"""A user's command, as the scripts call it."""

import shlex
import signal
import subprocess
import sys


def run(module: str, *arguments: object, quiet: bool = False) -> None:
    """`python -m module …`; where it fails its own message says what is wrong, and this process ends, too.

    `quiet` keeps what it says to itself until it fails. Ctrl-C, which reaches the command as well, waits for it: it
    saves what it has, and leaves nothing half-written.
    """
    command = [sys.executable, "-m", module, *map(str, arguments)]
    output = subprocess.PIPE if quiet else None
    with subprocess.Popen(command, stdout=output, stderr=output, text=True) as process:
        try:
            _, told = process.communicate()
        except KeyboardInterrupt:
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # A second Ctrl-C ends at once.
            process.communicate()
            raise
    if process.returncode:
        raise SystemExit(f"{shlex.join(command)}\n{told}" if told else process.returncode)
