"""The judge: how well a model reconstructs shapes and finds poses."""

import os

# onnxruntime tells its makers of its use, unless this is set before it is imported.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
