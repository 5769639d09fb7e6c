"""How many lanes a program has."""

import triton


def lanes(on_device: int) -> int:
    """As many as suit a GPU; thousands under Triton's interpreter, where an operation costs the same for any number."""
    return 4096 if triton.knobs.runtime.interpret else on_device


def tile(rows: int, columns: int) -> tuple[int, int]:
    """The same for two dimensions."""
    return (128, 128) if triton.knobs.runtime.interpret else (rows, columns)
