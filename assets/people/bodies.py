"""Naked rest bodies from anny (MakeHuman): x forward, y left, z up, metres."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

HIDDEN = ["eye_cavity.L", "eye_cavity.R", "mouth_cavity", "tongue", "eye_back.L", "eye_back.R"]


@dataclass(frozen=True)
class Body:
    """A skinned body in its rest pose (arms half raised)."""

    vertices: np.ndarray  # (V, 3) [m], the soles at z = 0
    faces: np.ndarray  # (F, 3)
    weights: np.ndarray  # (V, B), rows add up to one
    labels: list[str]  # of the B bones, parents before children
    parents: list[int]  # -1: none
    joints: np.ndarray  # (B, 3) [m] heads of the bones

    def joint(self, label: str) -> np.ndarray:
        """Head of a bone (3,) [m]."""
        return self.joints[self.labels.index(label)]

    def bones(self, *prefixes: str) -> np.ndarray:
        """(B,) whether a bone's name starts with one of `prefixes`."""
        return np.array([label.startswith(prefixes) for label in self.labels])

    def dominated(self, *prefixes: str) -> np.ndarray:
        """(V,) whether these bones move the vertex more than all others do."""
        return self.weights[:, self.bones(*prefixes)].sum(axis=1) > 0.5

    def scaled(self, factor: float) -> Body:
        """The same person taller or smaller."""
        return replace(self, vertices=self.vertices * factor, joints=self.joints * factor)


class BodyMaker:
    """Makes rest bodies by anny's phenotypes. The first use of anny builds its cache (a minute)."""

    def __init__(self) -> None:
        import anny
        import torch
        from anny.face_segmentation import get_face_segmentation_mask

        self._torch = torch
        self._model = anny.Anny(skinning_method="lbs").to(dtype=torch.float64)
        hidden = get_face_segmentation_mask(self._model, HIDDEN).numpy()
        self._faces = self._model.faces.numpy()[~hidden]

    def make(self, phenotype: dict[str, float], height: float) -> Body:
        """One body, `height` [m] from sole to crown.

        Args:
            phenotype: gender (0 man, 1 woman), age (2/3: 25 years, 1: 90), muscle, weight,
                height, proportions, all 0 to 1.
        """
        model, torch = self._model, self._torch
        pose = torch.eye(4, dtype=torch.float64).repeat(1, model.bone_count, 1, 1)
        with torch.no_grad():
            rest = model(pose_parameters=pose, phenotype_kwargs=phenotype)
        used, faces = np.unique(self._faces, return_inverse=True)
        vertices = _forward_is_x(rest["rest_vertices"][0].numpy()[used])
        joints = _forward_is_x(rest["rest_bone_heads"][0].numpy())
        weights = np.zeros((len(used), model.bone_count))
        indices = model.vertex_bone_indices.numpy()[used]
        rows = np.repeat(np.arange(len(used)), indices.shape[1])
        np.add.at(weights, (rows, indices.ravel()), model.vertex_bone_weights.numpy()[used].ravel())
        floor = np.array([joints[0, 0], 0.0, vertices[:, 2].min()])
        body = Body(
            vertices=vertices - floor,
            faces=faces.reshape(-1, 3),
            weights=weights / weights.sum(axis=1, keepdims=True),
            labels=list(model.bone_labels),
            parents=[int(p) for p in model.bone_parents],
            joints=joints - floor,
        )
        return body.scaled(height / body.vertices[:, 2].max())


def _forward_is_x(points: np.ndarray) -> np.ndarray:
    """From MakeHuman's axes, which look along -y."""
    return np.stack([-points[:, 1], points[:, 0], points[:, 2]], axis=1)
