"""Other differentiable renderers, each in the form that is the fastest for it among those that its users have."""

import importlib

from benchmarks.contender import Contender

# Modules here, each with a function `contenders`; they say by an exception that their renderer cannot be used.
INSTALLABLE = {"DEODR": "deodr", "Mitsuba 3": "mitsuba"}

# As of November 2026, for Linux without a GPU.
NOT_INSTALLABLE = {
    "PyTorch3D": "not installable: the package index has no file of it for Linux, and a repackaged source there "
    "lacks the headers",
    "DRTK": "not installable: not on the package index; `drtk` there is a placeholder of someone else's",
    "nvdiffrast": "not installable: not on the package index under its name; a repackaged wheel there needs a CUDA GPU",
}


def find_peers() -> tuple[list[Contender], dict[str, str]]:
    """The contenders that work on this machine, and for each renderer that does not, the reason."""
    contenders: list[Contender] = []
    absent = dict(NOT_INSTALLABLE)
    for name, module in INSTALLABLE.items():
        try:
            contenders += importlib.import_module(f"benchmarks.peers.{module}").contenders()
        except (ImportError, OSError, RuntimeError) as error:
            absent[name] = f"not usable here: {error}"
    return contenders, absent
