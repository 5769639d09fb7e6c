"""Without a GPU, Triton's interpreter runs the kernels; it must be asked for before triton's first import,
which any test module may bring about."""

import os

import torch

if not torch.cuda.is_available():
    os.environ["TRITON_INTERPRET"] = "1"
