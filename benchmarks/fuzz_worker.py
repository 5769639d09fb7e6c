"""One process that fuzzes one target until libFuzzer ends it.

`python -m benchmarks.fuzz_worker TARGET FOLDER MEBIBYTES [OPTION OF LIBFUZZER ...] CORPUS`
"""

import resource
import sys
from pathlib import Path
from typing import cast

import atheris

# What parses: libFuzzer is told of each branch that is taken there, and of each comparison.
INSTRUMENTED = ["imaging", "service", "PIL", "zipfile"]

with atheris.instrument_imports(include=INSTRUMENTED):
    from benchmarks.fuzz_mutation import mutator
    from benchmarks.fuzz_targets import Name, target_of


def main() -> None:
    name, folder, mebibytes, *options = sys.argv[1:]
    target = target_of(cast(Name, name), Path(folder))
    # Beyond this, whatever asks for memory gets none: a fault, unless the reader refuses the file for it.
    resource.setrlimit(resource.RLIMIT_AS, (int(mebibytes) * 2**20,) * 2)
    atheris.Setup([sys.argv[0], *options], target, custom_mutator=mutator(mutate))
    atheris.Fuzz()


def mutate(content: bytes, most: int) -> bytes:
    """libFuzzer's own mutation."""
    # Its name leads to what works only once fuzzing has begun.
    changed: bytes = atheris.Mutate(content, most)
    return changed


if __name__ == "__main__":
    main()
