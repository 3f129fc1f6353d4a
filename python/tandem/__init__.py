"""Tandem from Python: scenes, sessions in virtual time, and the analysis, as numpy arrays.

>>> import tandem
>>> scene = tandem.Scene("axis_distributed", {"coupler.ko1.stiffness": 500})
>>> tandem.judge(scene, delay_packets=1).stable
True

Everything is computed by the same code that the `tandem` program and the nodes run. SI units;
frequencies in rad/s. Wrong input raises ValueError (SceneError for scenes) with a message that
names the field, its value and what is allowed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import SceneError

__all__ = [
    "FreeMotion", "Judgement", "Scene", "SceneError", "Trajectory", "admittance", "damping",
    "judge", "scene_names", "simulate", "stability_boundary", "stability_map", "stable_intervals",
    "transition_matrix",
]


def __dir__() -> list[str]:
    # What the module offers, not what it is made with.
    return sorted(__all__ + [name for name in globals() if name.startswith("__")])


Edits = Mapping[str, object]


def _sets(edits: Edits | None) -> list[str]:
    return [] if edits is None else [f"{path}={_text(value)}" for path, value in edits.items()]


def _text(value: object) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)


class Scene:
    """A session's description: a shipped scene by name, or a file by path, with edits.

    Edits address fields as `--set` does: {"coupler.k11.stiffness": 800, "object.box.mass": 0.5}.
    Scenes do not change; `edited` returns another one.
    """

    def __init__(self, name_or_file: str, edits: Edits | None = None) -> None:
        self._scene = _core.load(str(name_or_file), _sets(edits))

    @classmethod
    def from_text(cls, text: str, edits: Edits | None = None) -> Scene:
        """A scene from protobuf text, as in a .scene file."""
        return cls._of(_core.parse(text, "text", _sets(edits)))

    @classmethod
    def _of(cls, core_scene: _core.Scene) -> Scene:
        scene = cls.__new__(cls)
        scene._scene = core_scene
        return scene

    def edited(self, edits: Edits) -> Scene:
        """The same scene with some fields changed, validated anew."""
        return self._of(_core.parse(self.text, self.name, _sets(edits)))

    def linearised(self) -> Scene:
        """The linear scene that the analysis judges: contacts attached at the grasp, no
        saturation, no encoder, no friction."""
        return self._of(_core.linearised(self._scene))

    @property
    def name(self) -> str:
        return self._scene.name

    @property
    def description(self) -> str:
        return self._scene.description

    @property
    def text(self) -> str:
        """Canonical protobuf text, defaults written out; reads back to the same scene."""
        return self._scene.text

    @property
    def hash(self) -> int:
        """Of what the peers of a session must agree on (64 bit)."""
        return self._scene.hash

    @property
    def space(self) -> str:
        """axis, plane or space."""
        return self._scene.space

    @property
    def architecture(self) -> str:
        """single, central, distributed or distributed_split."""
        return self._scene.architecture

    @property
    def users(self) -> list[str]:
        return self._scene.users

    @property
    def tick(self) -> float:
        """Sample period T [s]."""
        return self._scene.tick

    @property
    def packet_period(self) -> float:
        """T_t [s]."""
        return self._scene.packet_period

    def __repr__(self) -> str:
        return (f"<Scene {self.name}: {self.space}, {self.architecture}, "
                f"{len(self.users)} users, hash {self.hash:016x}>")


def scene_names() -> list[str]:
    """Names of the shipped scenes."""
    return _core.scene_names()


@dataclass(frozen=True)
class Trajectory:
    """What a session did; K rows."""

    time: NDArray[np.float64]  #: (K,) end of the tick [s]
    poses: NDArray[np.float64]  #: (K, users, objects, 1 | 3 | 7): x | x, y, angle | x, y, z, qw..qz
    positions: NDArray[np.float64]  #: (K, fingers, 1 | 2 | 3) of the fingers [m]
    forces: NDArray[np.float64]  #: (K, fingers, 1 | 2 | 3) on the fingers [N]
    fingers: list[str]  #: "user.finger", in the order of the arrays
    packets_sent: int
    packets_accepted: int


def simulate(scene: Scene, seconds: float, *, delay_packets: float = 0.0, link_delay: float = 0.0,
             jitter: float = 0.0, loss: float = 0.0, seed: int = 1, every: int = 1) -> Trajectory:
    """Runs a session in virtual time with the scene's simulated hands.

    delay_packets: round trip in packet periods, all of it on one direction; link_delay, jitter:
    one-way delay and the standard deviation of a normal jitter of every link [s]; loss: 0 to 1;
    every: one row each so many ticks. The same arguments give the same bits. Ctrl-C ends it.
    """
    return Trajectory(**_core.simulate(scene._scene, float(seconds), float(delay_packets),
                                       float(link_delay), float(jitter), float(loss), int(seed),
                                       int(every)))


@dataclass(frozen=True)
class Judgement:
    """The closed loop over a packet period, common motions taken out."""

    radius: float  #: largest modulus of an eigenvalue, growth a packet period
    eigenvalues: NDArray[np.complex128]  #: largest modulus first
    removed: list[str]  #: common motions found and taken out exactly
    assumptions: list[str]  #: what was assumed to make the scene linear

    @property
    def stable(self) -> bool:
        return self.radius < 1.0


def judge(scene: Scene, delay_packets: float = 0.0, road: str = "auto") -> Judgement:
    """Stability of a scene, linearised at its grasp.

    road: "measured" from the running loop, "resampled" (thesis 4.1-4.11; faster, not for every
    scene), "auto": resampled where it applies.
    """
    return Judgement(**_core.judge(scene._scene, float(delay_packets), road))


def transition_matrix(scene: Scene, delay_packets: float = 0.0,
                      road: str = "measured") -> NDArray[np.float64]:
    """The lifted map over a packet period, (n, n), packets in flight among its states."""
    return _core.transition(scene._scene, float(delay_packets), road)


@dataclass(frozen=True)
class FreeMotion:
    """What a hand feels in slow free motion."""

    damping: float  #: against the mean velocity over a packet period [N s/m]
    sampled_damping: float  #: against the velocity at packet instants, thesis (6.2) [N s/m]
    inertia: float  #: [kg]


def damping(scene: Scene, user: str | None = None, delay_packets: float = 0.0, *,
            alone: bool = True) -> FreeMotion:
    """Drag in free motion (6.2), felt by a user (the first if none is named).

    alone: the other hands do not touch, as in chapter 6 of the thesis.
    """
    return FreeMotion(**_core.free_motion(scene._scene, user or scene.users[0],
                                          float(delay_packets), alone))


def admittance(scene: Scene, omega: ArrayLike, user: str | None = None,
               delay_packets: float = 0.0, *, alone: bool = True,
               of_position: bool = False) -> NDArray[np.complex128]:
    """V/F (6.1), or X/F, felt by a user at the frequencies `omega` [rad/s], any shape."""
    frequencies = np.asarray(omega, dtype=float)
    if not np.all(np.isfinite(frequencies)):
        raise ValueError("omega has entries that are not finite")
    response = _core.admittance(scene._scene, user or scene.users[0],
                                frequencies.ravel().tolist(), float(delay_packets), alone,
                                of_position)
    return response.reshape(frequencies.shape)


def stability_map(scene: Scene, x: str, x_range: tuple[float, float], y: str,
                  y_range: tuple[float, float], shape: tuple[int, int] = (100, 100),
                  delay_packets: float = 0.0, threads: int = 1) -> NDArray[np.bool_]:
    """Where the scene is stable, judged at the centres of shape = (rows, columns) equal cells.

    x, y: fields as in edits, several joined by commas are set alike
    ("coupler.ko1.stiffness,coupler.ko2.stiffness"). Row 0 is the lowest y. Ctrl-C ends it.
    """
    return _core.stability_map(scene._scene, x, tuple(map(float, x_range)), y,
                               tuple(map(float, y_range)), tuple(shape), float(delay_packets),
                               int(threads))


def stability_boundary(scene: Scene, x: str, x_range: tuple[float, float], y: str,
                       y_range: tuple[float, float], *, cells: int = 40, tolerance: float = 1e-6,
                       delay_packets: float = 0.0) -> NDArray[np.float64]:
    """The boundary of the stable region as segments, (n, 2, 2): both ends (x, y) lie on it to
    `tolerance` relative. Pass it to matplotlib's LineCollection."""
    return _core.stability_boundary(scene._scene, x, tuple(map(float, x_range)), y,
                                    tuple(map(float, y_range)), int(cells), float(tolerance),
                                    float(delay_packets))


def stable_intervals(scene: Scene, field: str, limits: tuple[float, float],
                     delay_packets: float = 0.0) -> NDArray[np.float64]:
    """All stable intervals of one field within `limits`, (n, 2)."""
    return _core.stable_intervals(scene._scene, field, tuple(map(float, limits)),
                                  float(delay_packets))
