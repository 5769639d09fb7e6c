"""Which symmetry the posteriors of poses tell, beside that of the objects: every bundle of fixed light.

    python -m benchmarks.symmetry --models models --real-meshes DIR

Pictures of procedural objects that no training or validation saw, and of real meshes, if any. Writes a JSON file with
the machine and, for each bundle and each order of its objects, how many pictures were told which order
(`azimuth_symmetry` of the service; `continuous` is the judge's word for a solid of revolution).
"""

import argparse
import math
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

from benchmarks.bundles import TEST_SEED, add_options, measure_bundles, rendered
from service.symmetry import symmetry_order
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import Pictures, from_folder, from_meshes
from trainer.evaluation.subject import Subject, predict


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser, 200, 6, Path("docs/results/symmetry.json"))
    measure_bundles("benchmarks.symmetry", parser.parse_args(), measured)
    return 0


def measured(bundle: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """All counts of one bundle."""
    subject = from_bundle(bundle)
    with tempfile.TemporaryDirectory() as folder:
        test = from_folder(rendered(Path(folder), subject, TEST_SEED, arguments.objects), subject.scene)
    found = {"test": _told(subject, test)}
    meshes = arguments.real_meshes and arguments.real_meshes / subject.category
    if meshes and meshes.is_dir():
        found["real_meshes"] = _told(subject, from_meshes(meshes, subject.scene, arguments.views))
    return found


def _told(subject: Subject, pictures: Pictures) -> dict[str, dict[str, int]]:
    """By the object's order, how many pictures were told which."""
    found: dict[str, Counter[str]] = {}
    probabilities = predict(subject, pictures.codes).probabilities.numpy()
    for number, told in zip(pictures.objects, probabilities, strict=True):
        order = pictures.truth[number].order
        name = "continuous" if math.isinf(order) else f"{order:.0f}"
        found.setdefault(name, Counter())[str(symmetry_order(told))] += 1
    return {name: dict(sorted(found[name].items(), key=lambda pair: int(pair[0]))) for name in sorted(found)}


if __name__ == "__main__":
    sys.exit(main())
