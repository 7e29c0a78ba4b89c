"""``python -m benchmarks.reliability.inputs``: cases of one kind, or one case again."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import click

from benchmarks.reliability.inputs import explorer
from benchmarks.reliability.inputs.campaign import KINDS, campaign
from benchmarks.reliability.inputs.cases import rng_of
from benchmarks.reliability.inputs.process import run_case


@click.command()
@click.argument("kind", type=click.Choice(tuple(KINDS)))
@click.argument("number", type=int, required=False)
@click.option("--count", type=click.IntRange(1), default=1000, show_default=True)
@click.option("--first", type=click.IntRange(0), default=0, help="Number of the first case.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
@click.option("--folder", type=click.Path(path_type=Path), help="Where the case is run and kept.")
def main(
    kind: str, number: int | None, count: int, first: int, seed: int, folder: Path | None
) -> None:
    """Run cases of a kind and count what is wrong by its words, or run one case and show it."""
    if number is not None:
        _one(kind, number, seed, folder)
        return
    for found in campaign([kind], count, seed, first=first):
        click.echo(
            f"{kind}: {found.cases} cases, {found.accepted} accepted, {found.refused} refused, "
            f"{found.failed} failed, {len(found.broken)} broken; longest {found.longest_s:.2f} s, "
            f"{found.peak_mb} MB; {found.seconds:.0f} s"
        )
        words = Counter(text.partition(": ")[2] for text in found.broken)
        first_of = {text.partition(": ")[2]: text.partition(": ")[0] for text in found.broken[::-1]}
        for text, times in words.most_common():
            click.echo(f"  {times:5} x {text}   [{first_of[text]}]")


def _one(kind: str, number: int, seed: int, folder: Path | None) -> None:
    maker, rng = KINDS[kind].maker, rng_of(seed, kind, number)
    if maker is None:
        scope, body = explorer.request(rng)
        click.echo(f"{scope}\n{body!r}\n{explorer.answer(scope, body)}")
        return
    case = maker(rng)
    click.echo(f"{case.arguments!r} {dict(case.environment)} {dict(case.links)}")
    if folder is not None:
        folder.mkdir(parents=True)
    click.echo(run_case(number, case, keep=folder))


if __name__ == "__main__":
    main()
