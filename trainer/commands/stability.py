"""`python -m trainer stability`"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, Self

from rich.console import Console

from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.stability.budget import BUDGETS, Budget, BudgetName
from trainer.stability.edges import edge_figures
from trainer.stability.examination import examine
from trainer.stability.models import contestants
from trainer.stability.page import filled, page_of
from trainer.stability.regimes import REGIMES, Regime
from trainer.stability.tables import Results
from trainer.stability.trainings import PRESET, found_trainings, recipe_for, run_trainings

_USUAL = ("car", "chair", "sofa")


@dataclass(frozen=True)
class StabilityCommand:
    """Test models and trainings where such methods fail, and whether what they report gives warning.

    Pictures: severity curves of damaged pictures, other cameras and lights, hard views, other classes, and how well
    confidence foretells errors. Trainings: short ones of cars, under adverse conditions. Rasteriser: against brute
    force, at grazing angles and where boxes interpenetrate. Writes stability.json, stability.md and charts into
    OUTPUT/BUDGET; what is there already is kept, and the same command goes on where it was interrupted.
    """

    bundle: tuple[Path, ...] = ()
    """Bundles to examine, as they are served; without any model, those of cars, chairs and sofas in models/."""
    checkpoint: tuple[Path, ...] = ()
    """Run directories or checkpoints to examine."""
    budget: BudgetName = "small"
    """small: a first look, in minutes. full: what docs/stability.md rests on, in an hour."""
    parts: tuple[Literal["pictures", "trainings", "rasteriser"], ...] = ("pictures", "trainings", "rasteriser")
    """What is tested."""
    regimes: tuple[str, ...] = ()
    """Kinds of trainings, by name; by default all."""
    seeds: int = 0
    """Trainings of each kind, 1 to 100; 0 means the budget's: 1, or 2."""
    output: Path = Path("out/stability")
    """Directory to write to."""
    page: Path | None = None
    """Text whose {…} are filled in with figures of stability.json, to be written as stability.md: docs/stability.md is
    made of docs/stability.template.md. By default all tables and charts."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        return cls()

    def run(self) -> None:
        folder, console = self.output / self.budget, Console(stderr=True, soft_wrap=True)
        regimes, template, budget = self._regimes(), self._template(), self._budget()

        def report(sentence: str) -> None:
            console.print(sentence, markup=False)

        if "pictures" in self.parts:
            self._examine(folder, budget, report)
        if "rasteriser" in self.parts and not (folder / "rasteriser.json").exists():
            report("rasteriser")
            _write(folder / "rasteriser.json", edge_figures(budget.scenes))
        if "trainings" in self.parts:
            run_trainings(folder, budget, regimes, recipe_for(budget), report)
        results = self._results(folder)
        _write(folder / "stability.json", results)
        charts = _charts(results, folder, report)
        text = page_of(results, charts) if template is None else filled(template, results)
        write_bytes(folder / "stability.md", text.encode())
        report(f"written: {folder}: stability.json, stability.md, {len(charts)} charts")

    def _budget(self) -> Budget:
        if not 0 <= self.seeds <= 100:
            raise ConfigError(f"Expected --seeds from 0 to 100, found {self.seeds}.")
        budget = BUDGETS[self.budget]
        return replace(budget, seeds=self.seeds) if self.seeds else budget

    def _regimes(self) -> list[Regime]:
        known = {regime.name: regime for regime in REGIMES}
        if unknown := set(self.regimes) - set(known):
            raise ConfigError(f"Expected --regimes out of {', '.join(known)}, found {unknown.pop()}.")
        return [known[name] for name in self.regimes or known]

    def _template(self) -> str | None:
        """Raises ConfigError for a page that cannot be read: before anything takes long."""
        try:
            return None if self.page is None else self.page.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"The page {self.page} cannot be read ({error}). Check the path.") from error

    def _examine(self, folder: Path, budget: Budget, report: Callable[[str], None]) -> None:
        bundles = self.bundle
        if not bundles and not self.checkpoint:
            bundles = tuple(path for name in _USUAL if (path := Path("models") / name).is_dir())
            if not bundles:
                raise ConfigError("Expected --bundle DIR or --checkpoint RUN, found neither, and no models/ here.")
        for contestant in contestants(bundles, self.checkpoint):
            path = folder / "models" / f"{contestant.name}.json"
            if path.exists() and json.loads(path.read_text())["digest"] == contestant.digest:
                continue

            def tell(sentence: str, name: str = contestant.name) -> None:
                report(f"{name}: {sentence}")

            _write(path, examine(contestant, budget, tell))

    def _results(self, folder: Path) -> Results:
        """All that was found with this budget, also by earlier calls."""
        files = sorted((folder / "models").glob("*.json"), key=lambda path: path.stem)
        models = {path.stem: json.loads(path.read_text()) for path in files}
        rasteriser = folder / "rasteriser.json"
        return {
            "budget": {"name": self.budget, "preset": PRESET, **asdict(BUDGETS[self.budget])},
            "models": models,
            "trainings": found_trainings(folder),
            "rasteriser": json.loads(rasteriser.read_text()) if rasteriser.exists() else {},
        }


def _charts(results: Results, folder: Path, report: Callable[[str], None]) -> list[str]:
    """The names of the charts that are drawn; none, and a sentence on it, without matplotlib."""
    if find_spec("matplotlib") is None:
        report("no charts: they need matplotlib, which comes with the extra bench (pip install '.[bench]')")
        return []
    written: list[Path] = import_module("trainer.stability.charts").write_charts(results, folder)
    return [path.name for path in written]


def _write(path: Path, content: dict[str, Any]) -> None:
    write_bytes(path, (json.dumps(content, indent=1, allow_nan=False) + "\n").encode())
