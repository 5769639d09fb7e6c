"""The service: from a bundle to HTTP. A picture goes in, a mesh with its camera and lights comes out.

Needs onnxruntime, numpy, Pillow and FastAPI; never torch, never the trainer, never the exporter.
"""

import os

# onnxruntime tells its makers of its use, unless this is set before it is imported.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
