"""Training: shapes, pictures, the model, how it is trained, and how it is judged."""

import os
from typing import Final

SPIN_COUNT: Final = 3000
"""How many times libgomp's threads look for more work before they sleep. By itself it has them look 300,000 times:
where another program wants their core, each waits for those that are kept from working (docs/decisions.md)."""

# libgomp reads it once, when torch is imported.
if "OMP_WAIT_POLICY" not in os.environ:
    os.environ.setdefault("GOMP_SPINCOUNT", str(SPIN_COUNT))
