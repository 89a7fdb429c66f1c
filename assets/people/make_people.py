#!/usr/bin/env python3
"""Makes the people of the simulated warehouse: clothed bodies, standing and walking.

The results, `src/safe_passage/simulation/people/*.npz`, are committed; run this only to change
them. Its needs are not the package's own; a fresh environment takes a few minutes:

    python3 -m venv /tmp/people && . /tmp/people/bin/activate
    pip install torch==2.13.0 anny==0.6.2 scipy trimesh fast-simplification
    python3 assets/people/make_people.py [--only NAME] [--out FOLDER]

The first run builds anny's cache (a minute); a person takes about ten seconds. Nothing is drawn
by chance but cloth folds and the ease of standing, both by the person's seed.
"""

from __future__ import annotations

import argparse
import pickle
import time
from pathlib import Path

import numpy as np
from bodies import Body, BodyMaker
from clothes import SOLE, dressed
from gait import Poser, skinned
from meshes import Part, thinned
from painting import painted
from people import PEOPLE, Person

OUT = Path(__file__).resolve().parents[2] / "src/safe_passage/simulation/people"
PHASES = 16  # of the walk: a body moves 8 cm from one to the next
STEP = 1e-4  # [m] of the stored coordinates
FACES = {"jacket": 640, "trousers": 520, "head": 560, "skin": 110, "shoes": 60, "hair": 90,
         "helmet": 110}  # fmt: skip
REGIONS = ("head", "hair", "helmet", "skin", "jacket", "trousers", "shoes")


def make(body: Body, person: Person, share: float = 1.0) -> dict[str, np.ndarray]:
    """Everything `people_assets.load_person` reads. `share` scales the number of faces."""
    full = dressed(body, person)
    parts = [thinned(part, round(FACES[part.region] * share)) for part in full]
    texture, texcoords, corners = painted(parts, body, person)
    stride = round(person.step * person.height, 2)
    poser = Poser(body, SOLE, stride)
    phases = np.arange(PHASES) / PHASES
    poses = [poser.standing(person.seed)] + [poser.walking(phase) for phase in phases]
    vertices = np.stack([_figure(parts, pose) for pose in poses])
    regions = np.concatenate(
        [np.full(len(p.faces), REGIONS.index(p.region), np.uint8) for p in parts]
    )
    offsets = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    return {
        "vertices": np.round(vertices / STEP).astype(np.int16),
        "step_m": np.float64(STEP),
        "faces": np.concatenate([p.faces + o for p, o in zip(parts, offsets)]).astype(np.uint16),
        "texcoords": texcoords.astype(np.float16),
        "face_texcoords": corners.astype(np.uint16),
        "texture": texture,
        "face_regions": regions,
        "region_names": np.array(REGIONS),
        "phases": np.concatenate([[np.nan], phases]),
        "stride_m": np.float64(stride),
        "height_m": np.float64(vertices[0, :, 2].max()),
        "palette": _palette(texture, texcoords, corners, regions),
        "licence": np.array("CC0-1.0"),
    }


def _figure(parts: list[Part], pose: np.ndarray) -> np.ndarray:
    return np.concatenate([skinned(p.vertices, p.weights, pose) for p in parts])


def _palette(
    texture: np.ndarray, texcoords: np.ndarray, corners: np.ndarray, regions: np.ndarray
) -> np.ndarray:
    """(R, 3) uint8 mean colour of every region; grey for one that this person lacks."""
    middle = texcoords[corners].mean(axis=1)
    rows = (middle[:, 1] * (texture.shape[0] - 1)).astype(int)
    columns = (middle[:, 0] * (texture.shape[1] - 1)).astype(int)
    colours = texture[rows, columns].astype(float)
    means = [
        colours[regions == r].mean(axis=0) if (regions == r).any() else np.full(3, 128.0)
        for r in range(len(REGIONS))
    ]
    return np.round(means).astype(np.uint8)


def body_of(maker: BodyMaker, person: Person) -> Body:
    """The naked body that makes the clothed person as tall as it shall be."""
    above = 0.03 if "helmet" in person.extras or "cap" in person.extras else person.hair_thickness
    return maker.make(person.phenotype, person.height - SOLE - above)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--only", metavar="NAME", help="make this person alone")
    options.add_argument("--out", type=Path, default=OUT)
    options.add_argument("--share", type=float, default=1.0, help="of the usual number of faces")
    options.add_argument("--bodies", type=Path, help="keep the naked bodies in this pickle")
    chosen = options.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    if chosen.bodies and chosen.bodies.exists():
        bodies = pickle.loads(chosen.bodies.read_bytes())
    else:
        maker = BodyMaker()
        bodies = {person.name: body_of(maker, person) for person in PEOPLE}
        if chosen.bodies:
            chosen.bodies.write_bytes(pickle.dumps(bodies))
    for person in PEOPLE:
        if chosen.only not in (None, person.name):
            continue
        start = time.monotonic()
        data = make(bodies[person.name], person, chosen.share)
        path = chosen.out / f"{person.name}.npz"
        np.savez_compressed(path, **data)
        print(
            f"{person.name}: {data['height_m']:.3f} m, {len(data['faces'])} faces,"
            f" {data['vertices'].shape[1]} vertices, stride {data['stride_m']} m,"
            f" {path.stat().st_size / 1e3:.0f} kB, {time.monotonic() - start:.0f} s"
        )


if __name__ == "__main__":
    main()
