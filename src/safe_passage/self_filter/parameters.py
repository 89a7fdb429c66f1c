"""Parameters of the self-filter."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Mapping

from safe_passage.core.errors import ParameterError, shown
from safe_passage.core.parameters import check_flag, check_range, check_text


@dataclass(frozen=True)
class SelfFilterParameters:
    """What counts as robot."""

    padding: float = 0.02  # [m] outwards of every surface: calibration, cables, what bends
    link_padding: Mapping[str, float] = field(default_factory=dict)  # [m] in its place, by link
    excluded_links: tuple[str, ...] = ()  # that are not taken out
    visual: bool = True  # the links' visual geometry, not the collision's
    mesh_resolution: float = 0.006  # [m] to which meshes are simplified; 0: drawn as they are

    depth_noise: float = 0.008  # [1/m] a measured depth z is off by this times z^2 at most
    edge: int = 1  # [px] by which an outline frays
    sliver_band: int = 3  # [px] around what is removed, where mixed pixels are looked for
    sliver_support: int = 7  # pixels of 24 around it whose depth a true one shares; 0: never asked
    sliver_depth: float = 0.03  # [m] within which two depths are one, besides their noise

    time_uncertainty: float = 0.015  # [s] between the image's stamp and the joints', at most
    joint_tolerance: float = 0.05  # [s] that joint states may end before the image's stamp
    joint_gap: float = 0.2  # [s] between two joint states, at most

    def __post_init__(self) -> None:
        check_range("padding", self.padding, 0.0, 0.5, "m")
        if not isinstance(self.link_padding, Mapping):
            raise ParameterError(
                f"link_padding is {shown(self.link_padding)}, must be link: padding"
            )
        check_flag("visual", self.visual)
        for link, padding in self.link_padding.items():
            check_range(f"link_padding/{link}", padding, 0.0, 0.5, "m")
        for link in self.excluded_links:
            check_text("excluded_links", link)
        if set(self.excluded_links) & set(self.link_padding):
            raise ParameterError("excluded_links: a link in it has a link_padding, too")
        check_range("mesh_resolution", self.mesh_resolution, 0.0, 0.1, "m")
        check_range("depth_noise", self.depth_noise, 0.0, 0.5, "1/m")
        check_range("edge", self.edge, 0, 20, "px")
        check_range("sliver_band", self.sliver_band, 0, 20, "px")
        check_range("sliver_support", self.sliver_support, 0, 24, "pixels")
        check_range("sliver_depth", self.sliver_depth, 0.0, 1.0, "m")
        check_range("time_uncertainty", self.time_uncertainty, 0.0, 0.5, "s")
        check_range("joint_tolerance", self.joint_tolerance, self.time_uncertainty, 1.0, "s")
        check_range("joint_gap", self.joint_gap, 0.001, 5.0, "s")
