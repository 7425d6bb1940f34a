"""python -m tests.truth OUT --seed 1 --effect dry-friction coulomb_front_N=75 coulomb_rear_N=55"""

from __future__ import annotations

import argparse

from . import PRESETS, known_ids, make_campaign


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m tests.truth",
        description="Write a campaign with hidden effects.",
        epilog="effects: " + ", ".join(sorted(known_ids())),
    )
    parser.add_argument("out", metavar="OUT", help="folder to write")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--effect", nargs="+", action="append", default=[], metavar="ID KEY=VALUE")
    parser.add_argument("--preset", choices=PRESETS, default="atv")
    parser.add_argument("--short", action="store_true", help="8 runs instead of 18")
    parser.add_argument("--noise-rms", type=float, default=0.1, help="in band, m/s2")
    given = parser.parse_args()
    try:
        effects = {name: dict(map(assignment, values)) for name, *values in given.effect}
        folder = make_campaign(
            given.out,
            seed=given.seed,
            effects=effects,
            preset=given.preset,
            short=given.short,
            noise_rms=given.noise_rms,
        )
    except ValueError as error:
        parser.error(str(error))
    print(folder)


def assignment(text: str) -> tuple[str, float | str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"{text!r} is not KEY=VALUE")
    try:
        return key, float(value)
    except ValueError:
        return key, value


if __name__ == "__main__":
    main()
