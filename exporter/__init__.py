"""The exporter: from a checkpoint to a bundle, and the proof that both say the same."""

import os

# onnxruntime tells its makers of its use, unless this is set before it is imported.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
