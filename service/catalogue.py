"""The bundles that a service offers, by category."""

import logging
from dataclasses import dataclass, field
from pathlib import Path

from service.bundle import MANIFEST_FILE, Bundle, read_bundle
from service.errors import BundleError, CategoryError, NotReadyError
from service.inference import Engine, load_engine

logger = logging.getLogger(__name__)


@dataclass
class Catalogue:
    """Bundles that were read, and the engines that are proven so far.

    `load` may run in a thread of its own while other threads ask: an engine appears only after its probe agreed.
    """

    bundles: tuple[Bundle, ...]
    """Those that are still to be loaded."""
    engines: dict[str, Engine] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    """Why a category is not served."""
    names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.names = tuple(sorted(bundle.manifest.category for bundle in self.bundles))

    @property
    def ready(self) -> bool:
        """Whether every bundle's probe agreed."""
        return len(self.engines) == len(self.names)

    def load(self) -> None:
        """Make an engine of every bundle. A bundle that fails leaves its sentence in `failures`, and the rest serve."""
        # One by one, so that a graph's bytes are let go as soon as its engine holds them.
        while self.bundles:
            bundle = self.bundles[0]
            try:
                self.engines[bundle.manifest.category] = load_engine(bundle)
            except BundleError as error:
                self._fail(bundle, str(error))
            except Exception as error:
                # Whatever it is, memory for example: the others are still to be served, and nobody is to wait for it.
                logger.exception("%s could not be loaded", bundle.path)
                self._fail(bundle, f"{bundle.path}: expected a model that can be loaded, found {type(error).__name__}")
            self.bundles = self.bundles[1:]

    def _fail(self, bundle: Bundle, sentence: str) -> None:
        logger.error("%s is not served: %s", bundle.manifest.category, sentence)
        self.failures[bundle.manifest.category] = sentence

    def engine(self, category: str | None) -> Engine:
        """The engine of a category; without a name, that of the only bundle.

        Raises:
            CategoryError: no bundle serves the category, or none is named and there are several.
            NotReadyError: the category's bundle is not proven.
        """
        names = ", ".join(self.names)
        if category is None and len(self.names) != 1:
            raise CategoryError(f"expected a category, one of {names}, found none; name one")
        wanted = self.names[0] if category is None else category
        if wanted not in self.names:
            raise CategoryError(f"expected one of {names}, found category “{wanted[:64]}”; name one of those")
        found = self.engines.get(wanted)
        if found is None:
            raise NotReadyError(
                self.failures.get(wanted, f"the model of {wanted} is being loaded; try again in a second")
            )
        return found

    def all_engines(self) -> list[Engine]:
        """The engines of all categories, by name; without those whose bundles failed.

        Raises:
            NotReadyError: some are still being loaded, or none is left.
        """
        if len(self.engines) + len(self.failures) < len(self.names):
            raise NotReadyError("the models are being loaded; try again in a second")
        if not self.engines:
            raise NotReadyError("; ".join(self.failures.values()) or "there is no model; export one, and name it")
        return [self.engines[name] for name in sorted(self.engines)]


def read_catalogue(directory: Path) -> Catalogue:
    """The bundle in a directory, or all bundles in its subdirectories; hidden ones are skipped.

    Raises:
        BundleError: no bundle is there, one is not to be trusted, or two serve the same category.
    """
    if not directory.is_dir():
        raise BundleError(
            f"{directory}: expected a bundle or a directory of bundles, found no directory; "
            "name one with --models, or export a model there first"
        )
    if (directory / MANIFEST_FILE).exists():
        paths = [directory]
    else:
        paths = sorted(path for path in directory.iterdir() if path.is_dir() and not path.name.startswith("."))
    if not paths:
        raise BundleError(
            f"{directory}: expected a {MANIFEST_FILE} or directories that hold one, found neither; "
            "name another directory with --models, or export a model there first"
        )
    bundles = tuple(read_bundle(path) for path in paths)
    seen: dict[str, Path] = {}
    for bundle in bundles:
        category = bundle.manifest.category
        if category in seen:
            raise BundleError(
                f"{directory}: expected one bundle a category, found {seen[category].name} and {bundle.path.name} for "
                f"{category}; remove one of them"
            )
        seen[category] = bundle.path
    return Catalogue(bundles)
