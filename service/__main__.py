"""python -m service: serve bundles over HTTP."""

import socket
import sys

import tyro

from service.catalogue import read_catalogue
from service.errors import BundleError, SettingsError
from service.serving import serve, serve_in_processes
from service.settings import Settings, check_settings, environment_settings


def main() -> int:
    """Read the options, read the bundles, listen. Returns the exit status: 2 where something has to be mended."""
    try:
        defaults = environment_settings()
        settings = tyro.cli(Settings, default=defaults, description=Settings.__doc__, prog="python -m service")
        check_settings(settings)
        catalogue = read_catalogue(settings.models)
    except (SettingsError, BundleError) as error:
        print(error, file=sys.stderr)
        return 2
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    # asyncio sends what is written at once only where a socket says that its protocol is TCP. Else the kernel keeps a
    # body back until the client has confirmed the head, which takes 40 ms on a connection that is kept open.
    with socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((settings.host, settings.port))
            # Whoever reads the address below may connect at once.
            listener.listen(2048)
        except OSError as error:
            print(
                f"--host {settings.host} --port {settings.port}: expected an address that is free, found: "
                f"{error.strerror}; stop what listens there, or name another port",
                file=sys.stderr,
            )
            return 2
        host = f"[{settings.host}]" if family == socket.AF_INET6 else settings.host
        names = ", ".join(catalogue.names)
        print(f"serving {names} at http://{host}:{listener.getsockname()[1]} (documentation: /docs)", flush=True)
        if settings.workers > 1:
            return serve_in_processes(listener, settings)
        serve(listener, catalogue, settings)
    return 0


if __name__ == "__main__":
    sys.exit(main())
