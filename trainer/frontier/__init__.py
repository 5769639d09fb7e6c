"""Accuracy against cost. Importing this before onnxruntime keeps it from reporting to its maker."""

import os

os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
