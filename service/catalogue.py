"""The bundles that a service offers, by category."""

from dataclasses import dataclass, field
from pathlib import Path

from service.bundle import MANIFEST_FILE, Bundle, read_bundle
from service.errors import BundleError, CategoryError, NotReadyError
from service.inference import Engine, load_engine


@dataclass
class Catalogue:
    """Bundles that were read, and the engines that are proven so far.

    `load` may run in a thread of its own while other threads ask: an engine appears only after its probe agreed.
    """

    bundles: tuple[Bundle, ...]
    engines: dict[str, Engine] = field(default_factory=dict)
    failure: str | None = None

    @property
    def ready(self) -> bool:
        """Whether every bundle's probe agreed."""
        return len(self.engines) == len(self.bundles)

    def load(self) -> None:
        """Make an engine of every bundle. A bundle that fails leaves its sentence in `failure`, and the rest serve."""
        for bundle in self.bundles:
            try:
                self.engines[bundle.manifest.category] = load_engine(bundle)
            except BundleError as error:
                self.failure = self.failure or str(error)

    def engine(self, category: str | None) -> Engine:
        """The engine of a category; without a name, that of the only bundle.

        Raises:
            CategoryError: no bundle serves the category, or none is named and there are several.
            NotReadyError: the category's bundle is not proven.
        """
        names = sorted(bundle.manifest.category for bundle in self.bundles)
        if category is None and len(names) > 1:
            raise CategoryError(f"expected a category, one of {', '.join(names)}, found none; name one")
        wanted = names[0] if category is None else category
        if wanted not in names:
            raise CategoryError(
                f"expected one of {', '.join(names)}, found category “{wanted[:64]}”; name one of those"
            )
        found = self.engines.get(wanted)
        if found is None:
            raise NotReadyError(self.failure or f"the model of {wanted} is being loaded; try again in a second")
        return found


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
