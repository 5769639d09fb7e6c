"""What several pictures of an object tell beyond one: bundles judged on 1, 2, 4 and 8 of them at once, as served.

    python -m benchmarks.several --models models --real-meshes DIR

Procedural objects that no training or validation saw, and real meshes, if any, in eight views each. Writes a JSON file
with the machine and, for each bundle, IoU and Chamfer distance by the number of pictures, and what both would be if
shape codes were pooled by their largest numbers, as trainings of several pictures pool them.
"""

import argparse
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from benchmarks.bundles import TEST_SEED, add_options, measure_bundles, rendered
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import Pictures, from_folder, from_meshes, grouped
from trainer.evaluation.protocol import judge
from trainer.evaluation.report import as_json
from trainer.evaluation.subject import Subject

TOGETHER = (1, 2, 4, 8)
FIGURES = {"iou": "iou_unaligned", "chamfer_distance": "chamfer_distance_unaligned"}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser, 50, max(TOGETHER), Path("docs/results/several.json"))
    arguments = parser.parse_args()
    if arguments.views % max(TOGETHER):
        parser.error(f"expected --views to be a multiple of {max(TOGETHER)}, found {arguments.views}")
    threadpool_limits(1, "blas")
    measure_bundles("benchmarks.several", arguments, measured)
    return 0


def measured(bundle: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """All figures of one bundle."""
    subject = from_bundle(bundle)
    with tempfile.TemporaryDirectory() as folder:
        drawn = rendered(Path(folder), subject, TEST_SEED, arguments.objects, max(TOGETHER))
        found = {"test": _by_number(subject, from_folder(drawn, subject.scene))}
    meshes = arguments.real_meshes and arguments.real_meshes / subject.category
    if meshes and meshes.is_dir():
        found["real_meshes"] = _by_number(subject, from_meshes(meshes, subject.scene, arguments.views))
    return found


def _by_number(subject: Subject, pictures: Pictures) -> dict[str, Any]:
    """The judge's figures of groups of so many pictures, as they are served and by the largest numbers."""
    rules = {"served": subject, "largest": replace(subject, views_per_instance=max(TOGETHER))}
    judged: dict[str, Any] = {"objects": len(pictures.truth)}
    for rule, pooling in rules.items():
        reports = {count: as_json(judge(pooling, grouped(pictures, count), None).report) for count in TOGETHER}
        judged[rule] = {
            str(count): {name: report[figure] for name, figure in FIGURES.items()} for count, report in reports.items()
        }
    return judged


if __name__ == "__main__":
    sys.exit(main())
