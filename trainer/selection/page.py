"""A selection as programs and as people read it; the page is made of the JSON alone."""

import datetime
import os
import platform
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch

from trainer.mapping import to_mapping
from trainer.selection.bound import noise_variance
from trainer.selection.candidates import Candidate
from trainer.selection.choice import Choice
from trainer.selection.halving import WARM_UP_STEPS, Rung
from trainer.selection.record import Mean, Record, mean_of, paired, told
from trainer.selection.selection import Selection
from trainer.selection.size import Size
from trainer.selection.verdict import verdict_on

_UNKNOWN = "–"


def as_json(
    selection: Selection,
    sizes: Mapping[Candidate, Size],
    rungs: Sequence[Rung],
    choice: Choice,
    pictures: tuple[int, int],
    empty: Mean,
) -> dict[str, Any]:
    """All figures; `pictures` are those trained on and those held out, `empty` what black pictures would have."""
    recipe, budget = selection.recipe, selection.budget
    return {
        "class": selection.category,
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "machine": {"system": f"{platform.system()} {platform.machine()}", "cores": os.cpu_count()},
        "versions": {"python": platform.python_version(), "torch": torch.__version__},
        "pictures": pictures[0],
        "held_out_pictures": pictures[1],
        "held_out_objects": len(next(record for record in rungs[-1].judged.values() if not record.problem).values),
        "budget": budget._asdict(),
        "samples": selection.samples,
        "noise_variance": noise_variance(recipe.loss, recipe.width, recipe.height),
        "empty": empty._asdict(),
        "recipe": to_mapping(recipe),
        "rungs": [{"step": rung.step, "candidates": len(rung.judged), "kept": len(rung.kept)} for rung in rungs],
        "candidates": [_candidate(candidate, sizes[candidate], rungs, choice) for candidate in _in_order(rungs)],
        "best": choice.best.name,
        "chosen": choice.chosen.name,
    }


def _in_order(rungs: Sequence[Rung]) -> list[Candidate]:
    """The best first, and those that were dropped earlier after those that were dropped later."""
    found = dict.fromkeys(rungs[-1].kept)
    for rung in reversed(rungs):
        alive = [candidate for candidate, record in rung.judged.items() if record.problem is None]
        found |= dict.fromkeys(sorted(alive, key=lambda candidate: -rung.judged[candidate].mean))
        found |= dict.fromkeys(rung.judged)
    return list(found)


def _candidate(candidate: Candidate, size: Size, rungs: Sequence[Rung], choice: Choice) -> dict[str, Any]:
    """A candidate's figures; its differences are to the best of the last rung that it came to."""
    number, rung = next(
        (number, rung) for number, rung in reversed(list(enumerate(rungs, 1))) if candidate in rung.judged
    )
    record = rung.judged[candidate]
    reached = [
        _reached(other.judged[candidate])
        for other in rungs
        if candidate in other.judged and other.judged[candidate].problem is None
    ]
    behind = None
    if record.problem is None:
        behind = paired(rung.judged[rung.kept[0]], record)._asdict()
    verdict, why = verdict_on(candidate, rung, choice)
    return {
        "name": candidate.name,
        "form": candidate.form.name,
        "latent": candidate.latent,
        "light": candidate.light,
        "symmetry": candidate.symmetry,
        **size._asdict(),
        "rungs": reached,
        "behind_the_best": behind,
        "last_rung": number,
        "verdict": verdict,
        "why": why,
    }


def _reached(record: Record) -> dict[str, Any]:
    parts = {
        name: mean_of(np.array(getattr(record, name)))._asdict()
        for name in ("log_likelihood", "shape_nats", "angle_nats")
    }
    return {
        "step": record.step,
        "training_core_seconds": record.training_core_seconds,
        "judging_core_seconds": record.judging_core_seconds,
        "bound": mean_of(record.values)._asdict(),
        **parts,
    }


def as_markdown(found: Mapping[str, Any]) -> str:
    """The page that `trainer select` writes and prints."""
    lines = [
        f"# The smallest model that explains the pictures: {found['class']}",
        "",
        conditions(found),
        "",
        *table_lines(found),
        "",
        "*Bound*: lower bound of the log-likelihood of a held-out object's picture, nats, constants left out, ± a "
        "standard error over objects. A black picture in the place of each rendering would have "
        f"{told(_mean(found['empty']))}. *Behind the best*: the mean difference to the best candidate of the last rung "
        "that it came to, on the same objects, ± its standard error. *Pays*: the divergence of the shape code from its "
        "prior, nats, part of the bound.",
    ]
    return "\n".join(lines) + "\n"


def conditions(found: Mapping[str, Any]) -> str:
    """Who is chosen, and from what."""
    recipe, seconds = found["recipe"], found["budget"]["seconds"]
    time = f"{seconds / 60:g} minutes of a core in all" if seconds else "no limit of time"
    rungs = ", ".join(f"{rung['candidates']} to step {rung['step']}" for rung in found["rungs"])
    short = ""
    if seconds and found["rungs"][-1]["step"] <= WARM_UP_STEPS:
        short = (
            f" **That time was too short**: it was gone when {found['rungs'][0]['candidates']} candidates had made the "
            f"{WARM_UP_STEPS} steps that tell their pace, and so few steps tell nothing else. Give more --minutes, or "
            "fewer --forms, --latents, --lights or --symmetries, and another --output."
        )
    return (
        f"Chosen: **{found['chosen']}**. {found['pictures']} pictures to train on, {found['held_out_pictures']} "
        f"pictures of {found['held_out_objects']} other objects held out; {recipe['width']} × {recipe['height']}, seed "
        f"{recipe['seed']}, {time}. Trained: {rungs}.{short}"
    )


def table_lines(found: Mapping[str, Any]) -> list[str]:
    """A line for each candidate, the best first."""
    lines = [
        "| candidate | parameters (of the decoder) | bundle, kB | steps | bound | behind the best | pays | why |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for candidate in found["candidates"]:
        size = (
            f"{candidate['parameters']:,} ({candidate['shape_parameters']:,}) | {candidate['bundle_bytes'] / 1000:,.0f}"
        )
        name = f"**{candidate['name']}**" if candidate["name"] == found["chosen"] else candidate["name"]
        if not candidate["rungs"] or candidate["behind_the_best"] is None:
            lines.append(f"| {name} | {size} | {' | '.join([_UNKNOWN] * 4)} | {candidate['why']} |")
            continue
        last = candidate["rungs"][-1]
        behind = told(_mean(candidate["behind_the_best"])) if candidate["behind_the_best"]["value"] else "0"
        figures = [str(last["step"]), told(_mean(last["bound"])), behind, f"{last['shape_nats']['value']:.1f}"]
        lines.append(f"| {name} | {size} | {' | '.join(figures)} | {candidate['why']} |")
    return lines


def _mean(found: Mapping[str, float]) -> Mean:
    return Mean(found["value"], found["standard_error"])
