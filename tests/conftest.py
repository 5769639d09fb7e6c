"""Without a GPU, Triton's interpreter runs the kernels; it must be asked for before triton's first import,
which any test module may bring about."""

import contextlib
import os

import torch

if not torch.cuda.is_available():
    os.environ["TRITON_INTERPRET"] = "1"
# Now, and not after a test has opened OpenGL: Triton's LLVM crashes where Mesa's was loaded before it.
with contextlib.suppress(ImportError):
    import triton  # noqa: F401
