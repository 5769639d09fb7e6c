"""The service's settings: options of the command line, or variables of the environment in a container."""

import os
from pathlib import Path
from typing import Final

from pydantic import ValidationError
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.errors import SettingsError

_BOUNDS: Final = {
    "port": (0, 65535),
    "max_upload_bytes": (1024, 2**30),
    # Pillow's own limit, from which on it warns of what it takes for a bomb.
    "max_pixels": (64, 89_000_000),
    "upload_seconds": (1, 3600),
    "threads": (1, 256),
    "queue": (0, 65536),
    "deadline": (0, 3600),
    "refine_seconds": (0, 60),
    "workers": (1, 256),
}


class Settings(BaseSettings):
    """Answers pictures with meshes over HTTP. Each option can also be set by a variable, as in CHIARO_PORT=8000."""

    model_config = SettingsConfigDict(env_prefix="CHIARO_", extra="forbid", frozen=True)

    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets other machines in."""
    port: int = 8000
    """Port to listen on; 0 takes any free one and prints it."""
    models: Path = Path("models")
    """A bundle, or a directory of bundles."""
    max_upload_bytes: int = 10 * 2**20
    """Largest body of a request, bytes."""
    max_pixels: int = 25_000_000
    """Most pixels in the pictures of a request, all together."""
    upload_seconds: float = 60.0
    """How long a request's body may take to arrive."""
    threads: int = os.cpu_count() or 1
    """Pictures that are worked on at the same time; as many as there are cores suits best."""
    queue: int = 64
    """Requests that may wait for one of the threads; more are refused (429)."""
    deadline: float = 30.0
    """How long a request may wait for one of the threads, seconds, before it is given up (503); 0 is for ever."""
    refine_seconds: float = 1.0
    """How long an answer may be refined where a request asks for it, seconds; no iteration begins later."""
    workers: int = 1
    """Processes, each with threads, a queue, models and figures of its own."""


def environment_settings() -> Settings:
    """The defaults, as the environment changes them.

    Raises:
        SettingsError: a variable is not of its setting's type.
    """
    try:
        return Settings()
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        name = str(first["loc"][0])
        raise SettingsError(
            f"{_names(name)}: {first['msg']}, found {str(first['input'])[:60]}; see python -m service --help"
        ) from None


def check_settings(settings: Settings) -> None:
    """Raises SettingsError where a number is out of its bounds."""
    for name, (lowest, highest) in _BOUNDS.items():
        value = getattr(settings, name)
        if not lowest <= value <= highest:
            raise SettingsError(
                f"{_names(name)}: expected {lowest} to {highest}, found {value}; see python -m service --help"
            )


def _names(name: str) -> str:
    return f"--{name.replace('_', '-')} (or CHIARO_{name.upper()})"
