"""Equations of motion from springs, masses and forces between named nodes.

A linear mechanism with prescribed motions u(t) (ground heights, or measured axle motions) and
applied forces w(t) is

    M q̈ + C q̇ + K q = B u + D u̇ + E w − Σ Pᵀ f(δ, δ̇),     δ = P q + R u

with f the nonlinear force laws. Masses that stand upright on a foot and lean add what is written at
:meth:`Assembly.add_upright`. Parts are added one by one between *nodes*; the matrices are formed at
the end, so that a part may be added in any order, and a flexible mode of the body changes the
motion of every point already attached to it.

A node may be *carried*: its motion is that of another node and a prescribed one, but what carries
it takes up the forces on it. So measured travel prescribes how far an axle is from the body, and
the strut's force acts on the body alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Law = Callable[[float, float, float, float, float, Array], tuple[float, float]]
"""A force law, compiled with :func:`wheelhop.effects.law`: see there."""

FREE_1_S = 1e-6
"""A pole slower than this is that of a motion that nothing holds."""

LAW_PARAMETERS = 6
"""Room for so many numbers of each force law; more if one of them, a spline, takes more."""


@dataclass(frozen=True)
class Body:
    """A point of the sprung body, x ahead and y to the left of its centre of mass, metres."""

    x_m: float
    y_m: float


@dataclass(frozen=True)
class Coordinate:
    """A coordinate by name: a free one ("axle 1", "driver") or a prescribed one ("ground 1")."""

    name: str


@dataclass(frozen=True)
class Aboard:
    """What may be on a mount of its own: the free coordinate of this name if some part adds it,
    else the body's point `place`."""

    name: str
    place: Body


Node = Body | Coordinate | Aboard
Row = tuple[tuple[float, Node], ...]
"""A relative displacement: the sum of coefficient × vertical displacement of the node."""


def between(upper: Node, lower: Node) -> Row:
    """Extension of a part between two nodes: upper minus lower."""
    return ((1.0, upper), (-1.0, lower))


@dataclass(frozen=True)
class Reading:
    """An output that is no acceleration: `scale` times the displacement along `row`, m, its rate,
    or the force, N, of all springs, dampers and laws that act along this very row, positive in
    extension."""

    kind: Literal["displacement", "rate", "force"]
    row: Row
    scale: float = 1.0


@dataclass(frozen=True, eq=False)
class System:
    """A mechanism ready for integration or for its frequency response (shapes: n free, m
    prescribed coordinates, k applied forces, p ports of force laws, c outputs, r of them readings).

    An output shows the acceleration of a displacement, or a *reading*: a sum of displacements,
    rates and laws' forces.
    """

    mass: Array  #: (n, n) M, kg
    damping: Array  #: (n, n) C, N·s/m
    stiffness: Array  #: (n, n) K, N/m
    input_stiffness: Array  #: (n, m) B, N/m
    input_damping: Array  #: (n, m) D, N·s/m
    force: Array  #: (n, k) E
    port: Array  #: (p, n) P of the extensions
    port_input: Array  #: (p, m) R
    port_law: tuple[int, ...]  #: (p,) index into `laws` for each port
    laws: tuple[Law, ...]
    law_parameters: Array  #: (p, LAW_PARAMETERS or more)
    upright: Array  #: (s, 2, n) of what stands upright: its foot's vertical displacement, its angle
    upright_moment: Array  #: (s,) mass × height, kg·m
    output: Array  #: (c, n) accelerations shown = output @ q̈; NaN row: not predicted
    coordinates: tuple[str, ...] = ()  #: (n,) names of the free coordinates
    port_by: tuple[str, ...] = ()  #: (p,) input that each port's force is times, "" for none
    port_begins: tuple[str, ...] = ()
    """(p,) number of the run that each port's law remembers as the run begins, "" for 0"""
    port_force: Array | None = None  #: (p, n) P of the forces, where it is another
    reads: tuple[int, ...] = ()  #: (r,) the outputs that are readings; their row of `output` is 0
    reading: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """(r, 2 n + 2 m + p) what readings are of displacements q, rates q̇, prescribed motions u and
    their rates u̇, and laws' forces f"""

    @property
    def is_linear(self) -> bool:
        """Whether what moves it twice as much moves it twice as far."""
        return not self.laws and not len(self.upright)

    @property
    def reading_width(self) -> int:
        """2 n + 2 m + p: how many columns `reading` has."""
        return 2 * (len(self.mass) + int(self.input_stiffness.shape[1])) + len(self.port)

    @cached_property
    def leaning(self) -> tuple[Array, Array, Array]:
        """Three matrices for what stands upright. Times (x, ẋ) the first gives its angles and their
        rates; times ẍ the second gives their second rates and the accelerations of the feet. Times
        what pushes the feet and what turns the angles, per moment, the third gives accelerations.
        Readings have coordinates of their own there, as in `explicit`.
        """
        foot, angle = self.upright[:, 0], self.upright[:, 1]
        none, more = np.zeros_like(angle), (0, len(self.reads))
        pushed = np.concatenate([foot, angle]).T * np.tile(self.upright_moment, 2)
        return (
            self.widened(np.block([[angle, none], [none, angle]])),
            np.pad(np.concatenate([angle, foot]), ((0, 0), more)),
            np.pad(np.linalg.solve(self.mass, pushed), (more, (0, 0))),
        )

    def widened(self, state: Array) -> Array:
        """Columns (…, 2 n or more) of displacements and rates, and of what follows them, with
        zeros for the coordinates that `explicit` adds for readings."""
        n, r = len(self.mass), len(self.reads)
        return np.insert(state, [n] * r + [2 * n] * r, 0.0, axis=-1)

    @cached_property
    def explicit(self) -> tuple[Array, Array, Array]:
        """Three matrices, made once for all runs. Times z = (x, ẋ, u, u̇, w, f) the first gives the
        accelerations ẍ, the second the ports' extensions and rates; w are applied forces, f those
        of the laws. Times ẍ the third gives the outputs, zero where none is predicted.

        What is integrated puts out accelerations. So each reading y has a coordinate more, x_y with
        ẍ_y = y, that acts on nothing: its means over a sample's window are those of y.
        """
        inverse, ports, k = np.linalg.inv(self.mass), len(self.port), self.force.shape[1]
        inner, driven = [-self.stiffness, -self.damping], [self.input_stiffness, self.input_damping]
        pushed = self.port if self.port_force is None else self.port_force
        motion = [*inner, *driven, self.force, -pushed.T]
        none, unmoved = np.zeros_like(self.port), np.zeros_like(self.port_input)
        beyond = np.zeros((ports, k + ports))
        extension = [
            [self.port, none, self.port_input, unmoved, beyond],
            [none, self.port, unmoved, self.port_input, beyond],
        ]
        driven_end, r = self.reading.shape[1] - ports, len(self.reads)
        read = np.insert(self.reading, [driven_end] * k, 0.0, axis=1) if r else self.reading
        moved = [inverse @ np.hstack(motion), *([read] if r else [])]
        shown = np.pad(np.nan_to_num(self.output), ((0, 0), (0, r)))
        shown[list(self.reads), len(self.mass) + np.arange(r)] = 1.0
        return self.widened(np.vstack(moved)), self.widened(np.block(extension)), shown

    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues (2n,) of the linear part, rad/s."""
        n = len(self.mass)
        a = np.zeros((2 * n, 2 * n))
        a[:n, n:] = np.eye(n)
        a[n:, :n] = -np.linalg.solve(self.mass, self.stiffness)
        a[n:, n:] = -np.linalg.solve(self.mass, self.damping)
        return np.asarray(np.linalg.eigvals(a), dtype=np.complex128)

    @cached_property
    def fastest_1_s(self) -> float:
        """The largest of their magnitudes; not 0 where nothing holds the mechanism."""
        return max(float(np.abs(self.poles()).max()), FREE_1_S)


def kinetic_shares(shape: NDArray[np.complex128], mass: Array) -> Array:
    """What each coordinate has (k, n) of the kinetic energy xᴴ M x of modes x, `shape` (k, n), with
    the mass matrix (n, n): 1 in all. Where masses are coupled a share may be below 0."""
    each = (np.conj(shape) * (shape @ mass)).real
    return np.asarray(each / each.sum(axis=1, keepdims=True))


@dataclass
class Assembly:
    """Collects parts, then makes the :class:`System`. The motions of the rigid body, of "heave",
    "pitch" and "roll" those it has, are the first free coordinates."""

    prescribed: tuple[str, ...]
    body: tuple[str, ...] = ("heave", "pitch", "roll")
    _free: list[str] = field(default_factory=list)
    _modes: list[tuple[str, Callable[[float, float], float]]] = field(default_factory=list)
    _masses: list[tuple[Row, float]] = field(default_factory=list)
    _springs: list[tuple[Row, float, float]] = field(default_factory=list)
    _laws: list[tuple[Row, Law, tuple[float, ...], str, str]] = field(default_factory=list)
    _uprights: list[tuple[Row, Row, float]] = field(default_factory=list)
    _forces: list[Row] = field(default_factory=list)
    _outputs: list[Row | Reading | None] = field(default_factory=list)
    _carried: dict[str, Row] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._free += self.body

    def add_coordinate(self, name: str) -> Coordinate:
        """A new free coordinate (a vertical displacement, metres)."""
        self._free.append(name)
        return Coordinate(name)

    def add_carried(self, node: Coordinate, row: Row) -> None:
        """A node that moves as `row` says, and takes up no force."""
        self._carried[node.name] = row

    def add_body_mode(self, name: str, shape: Callable[[float, float], float]) -> Coordinate:
        """A flexible mode: the body's point (x, y) also moves by shape(x, y) × coordinate."""
        self._modes.append((name, shape))
        return self.add_coordinate(name)

    def add_mass(self, row: Row, mass_kg: float) -> None:
        """Kinetic energy ½ m (d row/dt)²; a negative mass takes inertia away."""
        self._masses.append((row, mass_kg))

    def add_spring(self, row: Row, stiffness_N_m: float, damping_N_s_m: float = 0.0) -> None:
        """A linear spring and damper along the extension `row`."""
        self._springs.append((row, stiffness_N_m, damping_N_s_m))

    def add_law(
        self,
        row: Row,
        law: Law,
        parameters: tuple[float, ...],
        by: str = "",
        begins: str = "",
    ) -> None:
        """A nonlinear force −f(δ, δ̇) along the extension `row`, in N; on a rig times the recorded
        input `by`, if one is named, and its memory as a run begins is that run's number `begins`
        ("my-effect.initial_N") instead of 0."""
        self._laws.append((row, law, parameters, by, begins))

    def add_upright(self, foot: Row, angle: Row, moment_kg_m: float) -> None:
        """What a mass m adds that stands at a height h above its foot and leans by an angle φ: it
        comes down by h φ²/2. Its moment is m h; a negative one takes away.

        To the second order in φ its kinetic energy ½ m (ż − h φ φ̇)² pushes the foot up with
        m h (φ̇² + φ φ̈) and turns the angle with m h z̈ φ. Its mass and inertia are added elsewhere,
        and so is its weight, which acts as a spring.
        """
        self._uprights.append((foot, angle, moment_kg_m))

    def add_force(self, row: Row) -> None:
        """An applied force along `row`; its history is the next column of w(t)."""
        self._forces.append(row)

    def add_output(self, shown: Row | Reading | None) -> None:
        """The next output: the acceleration of the displacement along a row, a reading, or None for
        one that is not predicted."""
        self._outputs.append(shown)

    def _vector(self, row: Row, *, of_force: bool = False) -> Array:
        """How the displacement `row` follows from all coordinates, or, `of_force`, what a force
        along it pushes."""
        index = {name: i for i, name in enumerate((*self._free, *self.prescribed))}
        vector = np.zeros(len(index))
        for coefficient, said in row:
            node = self._moves(said)
            if isinstance(node, Coordinate) and node.name in self._carried:
                if not of_force:
                    vector += coefficient * self._vector(self._carried[node.name])
                continue
            if isinstance(node, Coordinate):
                vector[index[node.name]] += coefficient
                continue
            # Pitch is positive nose down, roll positive right side down (campaign-format.md).
            rigid = {"heave": 1.0, "pitch": -node.x_m, "roll": node.y_m}
            for name in self.body:
                vector[index[name]] += coefficient * rigid[name]
            for name, shape in self._modes:
                vector[index[name]] += coefficient * shape(node.x_m, node.y_m)
        return vector

    def _moves(self, node: Node) -> Body | Coordinate:
        """The point or coordinate that a node moves with."""
        if isinstance(node, Aboard):
            return Coordinate(node.name) if node.name in self._free else node.place
        return node

    def _stack(self, rows: list[Row], *, of_force: bool = False) -> Array:
        n = len(self._free) + len(self.prescribed)
        found = [self._vector(row, of_force=of_force) for row in rows]
        return np.array(found).reshape(len(rows), n)

    def system(self, body_inertia: tuple[float, ...] = ()) -> System:
        """Form the matrices.

        Parameters
        ----------
        body_inertia
            Of the sprung body's motions, in their order: mass (kg), pitch and roll inertia (kg m²).
        """
        n = len(self._free)
        masses = self._stack([row for row, _ in self._masses])
        m = masses.T @ (np.array([value for _, value in self._masses])[:, None] * masses)
        rigid = len(body_inertia)
        m[:rigid, :rigid] += np.diag(body_inertia)
        along = [row for row, _, _ in self._springs]
        springs, pushed = self._stack(along), self._stack(along, of_force=True)
        k = pushed.T @ (np.array([value for _, value, _ in self._springs])[:, None] * springs)
        c = pushed.T @ (np.array([value for _, _, value in self._springs])[:, None] * springs)
        ports = self._stack([row for row, *_ in self._laws])
        forces = self._stack([row for row, *_ in self._laws], of_force=True)
        laws = tuple(dict.fromkeys(law for _, law, *_ in self._laws))
        width = max([LAW_PARAMETERS, *(len(values) for _, _, values, *_ in self._laws)])
        parameters = np.zeros((len(self._laws), width))
        for i, (_, _, values, *_) in enumerate(self._laws):
            parameters[i, : len(values)] = values
        upright = self._stack([row for *rows, _ in self._uprights for row in rows])
        output = np.full((len(self._outputs), n), np.nan)
        readings = {i: out for i, out in enumerate(self._outputs) if isinstance(out, Reading)}
        for i, out in enumerate(self._outputs):
            if isinstance(out, Reading):
                output[i] = 0.0
            elif out is not None:
                output[i] = self._vector(out)[:n]
        return System(
            mass=m[:n, :n],
            damping=c[:n, :n],
            stiffness=k[:n, :n],
            input_stiffness=-k[:n, n:],
            input_damping=-c[:n, n:],
            force=self._stack(self._forces, of_force=True)[:, :n].T.copy(),
            port=np.ascontiguousarray(ports[:, :n]),
            port_input=np.ascontiguousarray(ports[:, n:]),
            port_law=tuple(laws.index(law) for _, law, *_ in self._laws),
            laws=laws,
            law_parameters=parameters,
            upright=upright[:, :n].reshape(-1, 2, n),
            upright_moment=np.array([moment for *_, moment in self._uprights]),
            output=output,
            coordinates=tuple(self._free),
            port_by=tuple(by for *_, by, _ in self._laws),
            port_begins=tuple(begins for *_, begins in self._laws),
            port_force=np.ascontiguousarray(forces[:, :n]) if self._carried else None,
            reads=tuple(readings),
            reading=np.array([self._read(reading) for reading in readings.values()]).reshape(
                len(readings), 2 * ports.shape[1] + len(ports)
            ),
        )

    def _read(self, reading: Reading) -> Array:
        """The row (2 n + 2 m + p,) of `System.reading`."""
        n, row, scale = len(self._free), self._vector(reading.row), reading.scale
        of_motion, of_rate, of_laws = 0.0, 0.0, np.zeros(len(self._laws))
        if reading.kind == "force":
            along = [spring for spring in self._springs if spring[0] == reading.row]
            of_motion = sum(stiffness for _, stiffness, _ in along)
            of_rate = sum(damping for *_, damping in along)
            of_laws[[part[0] == reading.row for part in self._laws]] = scale
        elif reading.kind == "displacement":
            of_motion = 1.0
        else:
            of_rate = 1.0
        moved, rated = scale * of_motion * row, scale * of_rate * row
        return np.concatenate([moved[:n], rated[:n], moved[n:], rated[n:], of_laws])
