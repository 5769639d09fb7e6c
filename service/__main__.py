"""python -m service: serve bundles over HTTP."""

import signal
import socket
import sys
from types import FrameType

import tyro
import uvicorn

from service.app import create_app
from service.catalogue import read_catalogue
from service.errors import BundleError, SettingsError
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
    with socket.socket(family) as listener:
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
        names = ", ".join(bundle.manifest.category for bundle in catalogue.bundles)
        print(f"serving {names} at http://{host}:{listener.getsockname()[1]} (documentation: /docs)", flush=True)
        config = uvicorn.Config(create_app(catalogue, settings), log_level="warning", server_header=False)
        # uvicorn finishes what it began, and then raises the signal that stopped it once more.
        signal.signal(signal.SIGINT, _leave)
        signal.signal(signal.SIGTERM, _leave)
        uvicorn.Server(config).run(sockets=[listener])
    return 0


def _leave(_: int, __: FrameType | None) -> None:
    raise SystemExit(0)


if __name__ == "__main__":
    sys.exit(main())
