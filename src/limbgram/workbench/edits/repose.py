"""Repose: a joint turned about its anatomical axis, as plaster is wedged.

In      a limb of a kind that has joints, with the landmarks of the joint.
Out     the limb with all that lies distal of the joint turned, landmarks too.
        How far is said by the turn about the joint's own axis, or by the angle that the measuring
        sheet is to read after it; as the axis slants, one is not the other.
Method  Every vertex turns about the axis by its share of the angle, so that a band on both sides of
        the plane that parts the limb takes up the arc; places are not blended, which would thin it.
        Of a hinge the plane halves the way from the upper part to the lower one and turns along by
        half the angle; of the hindfoot it lies as the sole does half way through the turn. A
        vertex's share is that of its place half way between before and after. So the same turn back
        finds the same shares, and brings the shape back exactly. The turn to an angle is found by
        the secant method: the angle is read from the turned limb each time.
Fails   EditError: the joint is not of this kind, a landmark is missing, the turn or the strain is
        beyond what is stated and nobody accepted it, or beyond what is done at all; no turn leads
        to the angle.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Final, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import EditError, MeasureError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.topology import find_edges
from limbgram.core.request_fields import Within
from limbgram.findings import Finding, note
from limbgram.workbench.anatomy.directions import Anatomy
from limbgram.workbench.anatomy.kind import Angle, Joint, Tilted
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.anatomy.surface_lines import LineSurface, smoothstep
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import displaced
from limbgram.workbench.limb import Kind, Limb
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.sheet import SheetOptions, angle_deg, measuring_sheet

MOST_STRAIN, MOST_STRAIN_ACCEPTED = 0.25, 0.6
"""Strain of edges: the greatest without consent, and the greatest at all."""
MOST_DEG, MOST_DEG_ACCEPTED = 20.0, 45.0
_RIGID_MM, _SOFT_MM = 10.0, 15.0
"""Radius round a rigid landmark within which nothing turns, and width of the transition."""
_CEILING_FADE = (0.04, 0.15)
"""Heights over the ceiling between which the turn fades out, as shares of the foot's length."""
_SHARE_ROUNDS = 60
_CONVERGED_RAD = 1e-13
_ANGLE_TOLERANCE_DEG = 1e-6
"""The angle that is asked for is reached to within this."""
_SECANTS = 20
JOINTS: Final[dict[str, Joint]] = {
    joint.name: joint for kind in KIND_NAMED.values() for joint in kind.joints
}
if TYPE_CHECKING:
    JointName = str
else:
    JointName = Literal[tuple(JOINTS)]


@edit(
    group="orthosis",
    order=1,
    effect=Effect(reports_displacement=False, start="follows"),
    everyday=True,
    kinds=tuple(name for name, kind in KIND_NAMED.items() if kind.joints),
    example={"joint": "ankle", "by_deg": 5.0},
)
class Repose(Edit):
    """Turn what lies distal of a joint about its anatomical axis, as plaster is wedged."""

    joint: JointName = "ankle"
    """The joint, by the landmarks of its axis."""
    by_deg: Annotated[float, Within(-MOST_DEG_ACCEPTED, MOST_DEG_ACCEPTED)] | None = None
    """How far it turns about the joint's own axis. Positive: dorsiflexion, varus, toes up; of a
    trunk, to the right and backwards. The axis slants, so the angle that the sheet reads changes by
    somewhat less; what it changes by is said. Either this or the angle wanted."""
    to_deg: Annotated[float, Within(-180, 180)] | None = None
    """In place of that, the angle that the measuring sheet is to read: of the ankle that of shank
    and sole, 90 is plantigrade; of hindfoot and forefoot varus, positive; of the toes how far they
    point up from the sole; of a trunk the side bend or the lordosis."""
    band_mm: Annotated[float, Within(5, 150)] = 25.0
    """Half width of the band that takes up the arc."""
    beyond: bool = False
    """Somebody means a turn of more than 20 degrees, or a strain of more than 25 per cent."""
    axis_up_deg: Annotated[float, Within(0, 80)] | None = None
    """Of the hindfoot alone: how far its axis rises above the sole. Without it 42, the usual mean;
    persons lie far apart."""
    axis_medial_deg: Annotated[float, Within(-10, 60)] | None = None
    """How far that axis points to the medial side of the foot's. Without it 23."""

    words = spoken(
        en=Words(
            name="Turn a joint",
            title="The turn of a joint",
            labels={
                "joint": "Joint",
                "by_deg": "Turn by",
                "to_deg": "To the angle",
                "band_mm": "Band",
                "beyond": "Meant",
                "axis_up_deg": "Axis rises by",
                "axis_medial_deg": "Axis points medially by",
            },
            choices={one.name: one.words("en") for one in JOINTS.values()},
        ),
        de=Words(
            name="Gelenk stellen",
            title="Das Stellen eines Gelenks",
            does="Alles distal eines Gelenks um dessen anatomische Achse drehen, wie man Gips "
            "keilt.",
            labels={
                "joint": "Gelenk",
                "by_deg": "Drehen um",
                "to_deg": "Auf den Winkel",
                "band_mm": "Streifen",
                "beyond": "Gewollt",
                "axis_up_deg": "Achse steigt um",
                "axis_medial_deg": "Achse weist nach medial um",
            },
            help={
                "joint": "Das Gelenk, nach den Landmarken seiner Achse.",
                "by_deg": "Wie weit es sich um die eigene Achse des Gelenks dreht. Positiv: "
                "Dorsalextension, Varus, Zehen hoch; am Rumpf nach rechts und nach hinten. Die "
                "Achse liegt schräg, also ändert sich der Winkel auf dem Maßblatt um etwas "
                "weniger; um wie viel, wird gesagt. Entweder dies oder der gewünschte Winkel.",
                "to_deg": "Stattdessen der Winkel, den das Maßblatt danach zeigen soll: am "
                "Sprunggelenk der von Unterschenkel und Sohle, 90 ist plantigrad; an Rück- und "
                "Vorfuß der Varus, positiv; an den Zehen, wie weit sie über die Sohle weisen; am "
                "Rumpf die Seitneigung oder die Lordose.",
                "band_mm": "Halbe Breite des Streifens, der den Bogen aufnimmt.",
                "beyond": "Mehr als 20 Grad oder mehr als 25 Prozent Dehnung sind gewollt.",
                "axis_up_deg": "Nur am Rückfuß: wie steil seine Achse über der Sohle ansteigt. "
                "Ohne Angabe 42, das übliche Mittel; von Mensch zu Mensch sehr verschieden.",
                "axis_medial_deg": "Wie weit diese Achse von der des Fußes nach medial weist. Ohne "
                "Angabe 23.",
            },
            choices={one.name: one.words("de") for one in JOINTS.values()},
        ),
    )

    def check(self) -> None:
        """Refuse a turn that is said twice, or not at all.

        Raises:
            EditError: both are given, or neither.
        """
        if (self.by_deg is None) == (self.to_deg is None):
            raise EditError("edit.repose.one_of_two", both=self.by_deg is not None)

    def apply(self, limb: Limb) -> Limb:
        """Turn the distal part; notes tell the angle before and after, and how far the surface was
        strained.

        Raises:
            EditError: a landmark is missing, or more than is stated and accepted.
        """
        try:
            anatomy = self._with_asked_axis(limb.anatomy)
            _joint_of(anatomy, self.joint)
            by_deg = self.by_deg
            if by_deg is None:
                assert self.to_deg is not None
                by_deg = self._turn_to_angle(limb, anatomy, self.to_deg)
            turn = self._turn(anatomy, by_deg)
        except MeasureError as error:
            raise EditError("edit.repose.not_told", reason=error.finding) from error
        points = turn.applied(limb.mesh.vertices_mm)
        strain = largest_strain(limb.mesh.faces, limb.mesh.vertices_mm, points)
        if strain > MOST_STRAIN_ACCEPTED:
            raise EditError(
                "edit.repose.torn", by_deg=by_deg, strain=strain, most=MOST_STRAIN_ACCEPTED
            )
        if not self.beyond and (strain > MOST_STRAIN or abs(by_deg) > MOST_DEG):
            raise EditError(
                "edit.repose.beyond",
                by_deg=by_deg,
                strain=strain,
                most_deg=MOST_DEG,
                most=MOST_STRAIN,
            )
        after = displaced(limb, points)
        told = note("edit.repose.done", joint=self.joint, by_deg=by_deg, strain=strain)
        return replace(after, notes=(*after.notes, told, *angle_findings(limb, after, self.joint)))

    def places_of(self, kind: Kind) -> set[str]:
        joints = tuple(one for one in kind.joints if one.name == self.joint)
        read = {one.reads for one in joints if self.to_deg is not None}
        angles = [one for one in kind.sheet if isinstance(one, Angle) and one.name in read]
        return kind.names_in((joints, [(one.of, one.to, one.about) for one in angles]))

    def repeated(self, after: Limb) -> Edit:
        """The turn by as much: another skin has another angle before it."""
        if self.to_deg is None:
            return self
        done = next(one for one in reversed(after.notes) if one.code == "edit.repose.done")
        by_deg = done.values["by_deg"]
        assert isinstance(by_deg, float)
        return replace(self, to_deg=None, by_deg=by_deg)

    def _turn(self, anatomy: Anatomy, by_deg: float) -> "JointTurn":
        return JointTurn.of(anatomy, self.joint, by_deg * anatomy.mirror_sign(), self.band_mm)

    def _turn_to_angle(self, limb: Limb, anatomy: Anatomy, to_deg: float) -> float:
        """The turn after which the measuring sheet reads the angle that is asked for.

        Raises:
            MeasureError: a landmark that tells joint or angle is missing.
            EditError: no turn of the joint leads there.
        """
        item = joint_angle(self.joint)
        outer = replace(limb, mesh=outer_bodies(limb.mesh).mesh)

        def off_deg(by_deg: float) -> float:
            moved = outer
            if by_deg:
                points = self._turn(anatomy, by_deg).applied(outer.mesh.vertices_mm)
                moved = displaced(outer, points)
            seen = replace(moved.anatomy, skin=LineSurface(mesh=moved.mesh))
            return angle_deg(seen, item) - to_deg

        last, by_deg = 0.0, 1.0
        off = first = off_deg(last)
        for _ in range(_SECANTS):
            if abs(off) < _ANGLE_TOLERANCE_DEG:
                return last
            found = off_deg(by_deg)
            slope = (found - off) / (by_deg - last)
            last, off = by_deg, found
            by_deg -= found / slope if slope else np.inf
            if not abs(by_deg) <= MOST_DEG_ACCEPTED:
                break
        raise EditError(
            "edit.repose.out_of_reach",
            joint=self.joint,
            angle=item.en,
            to_deg=to_deg,
            before_deg=first + to_deg,
            most_deg=MOST_DEG_ACCEPTED,
        )

    def _with_asked_axis(self, anatomy: Anatomy) -> Anatomy:
        """The anatomy with the axis as it was asked for.

        Raises:
            EditError: landmarks tell the axis of the joint.
        """
        if self.axis_up_deg is None and self.axis_medial_deg is None:
            return anatomy
        axis = JOINTS[self.joint].axis
        if not any(isinstance(one, Tilted) and one.name == axis for one in anatomy.kind.directions):
            raise EditError("edit.repose.told_by_landmarks", joint=self.joint)
        kind = anatomy.kind.tilted(axis, self.axis_up_deg, self.axis_medial_deg)
        return replace(anatomy, kind=kind)


@dataclass(frozen=True, kw_only=True)
class JointTurn:
    """A turn about a joint's axis, from nothing proximal of a plane to the full angle distal."""

    centre_mm: Vector3
    axis: Vector3
    normal: Vector3
    """Normal of the plane that parts the limb, to the distal side; before the turn."""
    plane_point_mm: Vector3
    """A point on that plane."""
    ceiling_mm: Vector3
    upward: Vector3
    """What lies above the ceiling stays; upward is zero where there is none."""
    size_mm: float
    """Length from heel to toes, by which the fade under the ceiling is scaled."""
    plane_share: float
    """Share of the turn by which the plane itself turns: half for a hinge, zero for a twist."""
    angle_rad: float
    band_mm: float
    rigid_mm: tuple[Vector3, ...]

    @classmethod
    def of(cls, anatomy: Anatomy, name: str, by_deg: float, band_mm: float) -> "JointTurn":
        """The turn of a joint of the kind.

        Raises:
            MeasureError: the kind has no such joint, or a landmark of it was not placed.
        """
        joint = _joint_of(anatomy, name)
        axis, centre = anatomy.axis(joint.axis).direction, anatomy.at(joint.centre, joint.turn)
        upper = _unit(anatomy.at(joint.upper, joint.turn) - centre)
        lower = _unit(anatomy.at(joint.lower, joint.turn) - centre)
        if joint.twist:
            normal = axis if lower @ axis > upper @ axis else -axis
        elif joint.square is None:
            normal = _unit(_unit(_across_axis(lower, axis)) - _unit(_across_axis(upper, axis)))
        else:
            half = np.array([np.radians(by_deg) / 2])
            normal = -_rotated_offsets(anatomy.axis(joint.square).direction[None], axis, half)[0]
        return cls(
            centre_mm=centre,
            axis=axis,
            normal=normal,
            plane_point_mm=centre if joint.parted is None else anatomy.at(joint.parted, joint.turn),
            ceiling_mm=centre if joint.below is None else anatomy.at(joint.below, joint.turn),
            upward=_upward(anatomy, joint),
            size_mm=float(np.linalg.norm(anatomy.at(joint.lower) - anatomy.at(joint.upper))),
            plane_share=0.5 if joint.square is None and not joint.twist else 0.0,
            angle_rad=float(np.radians(by_deg)),
            band_mm=band_mm,
            rigid_mm=tuple(anatomy.places[one] for one in joint.rigid if one in anatomy.places),
        )

    def applied(self, points_mm: Points3) -> Points3:
        """Points after the turn."""
        return self._turned(points_mm, self.shares(points_mm) * self.angle_rad)

    def shares(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        """The share of the angle by which each point turns: 0 proximal, 1 distal.

        A fixed-point iteration, which converges fast if the band is wide for its arc.
        """
        share = self._shares_at(points_mm)
        for _ in range(_SHARE_ROUNDS):
            # Half way between before and after, seen from the plane, which goes along.
            half = (share - self.plane_share) * self.angle_rad / 2
            found = self._shares_at(self._turned(points_mm, half))
            change = float(np.abs(found - share).max(initial=0.0))
            share = found
            if change * abs(self.angle_rad) < _CONVERGED_RAD:
                break
        return share

    def _shares_at(self, places_mm: Points3) -> Float64[np.ndarray, " n"]:
        beyond = (places_mm - self.plane_point_mm) @ self.normal / self.band_mm
        found = smoothstep((beyond + 1) / 2)
        if self.upward.any():
            high = (places_mm - self.ceiling_mm) @ self.upward / self.size_mm
            found = found * smoothstep(
                (_CEILING_FADE[1] - high) / (_CEILING_FADE[1] - _CEILING_FADE[0])
            )
        for rigid in self.rigid_mm:
            away_mm = np.linalg.norm(places_mm - rigid, axis=1)
            found = found * smoothstep((away_mm - _RIGID_MM) / _SOFT_MM)
        return found

    def _turned(self, points_mm: Points3, angles_rad: Float64[np.ndarray, " n"]) -> Points3:
        return self.centre_mm + _rotated_offsets(points_mm - self.centre_mm, self.axis, angles_rad)


def joint_angle(joint: str) -> Angle:
    """The angle of the measuring sheet that describes a joint's position."""
    items = (item for kind in KIND_NAMED.values() for item in kind.sheet)
    wanted = JOINTS[joint].reads
    return next(one for one in items if isinstance(one, Angle) and one.name == wanted)


def _joint_of(anatomy: Anatomy, name: str) -> Joint:
    joint = next((one for one in anatomy.kind.joints if one.name == name), None)
    if joint is None:
        names = tuple(one.name for one in anatomy.kind.joints)
        raise MeasureError(
            "anatomy.no_joint", name=name, kind=anatomy.kind.name, names=names or None
        )
    return joint


def angle_findings(before: Limb, after: Limb, joint: str) -> tuple[Finding, ...]:
    """A note of a joint's angle before and after an edit, or of why it cannot be read; and a doubt
    about landmarks that stand in for others in it."""
    item = joint_angle(joint)
    asked = SheetOptions(only=(item.name,))
    try:
        sheets = [measuring_sheet(one, asked) for one in (before, after)]
        old, new = (sheet[item.name] for sheet in sheets)
    except MeasureError as error:
        return (note("edit.repose.not_read", angle=item.en, reason=error.finding),)
    read = note(
        "edit.repose.read",
        angle=item.en,
        before_deg=old.value,
        before_within_deg=_half_width(old),
        after_deg=new.value,
        after_within_deg=_half_width(new),
        change_deg=new.value - old.value,
    )
    doubts = [row.doubt for row in sheets[0].rows if row.stand_ins and row.doubt is not None]
    return (read, *doubts)


def _half_width(figure: Figure) -> float | None:
    return None if figure.interval is None else figure.interval.above


def largest_strain(faces: np.ndarray, before_mm: Points3, after_mm: Points3) -> float:
    """The largest relative change of an edge's length."""
    ends = find_edges(faces).ends
    lengths = [
        np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
        for points in (before_mm, after_mm)
    ]
    change = np.abs(lengths[1] - lengths[0]) / np.maximum(lengths[0], 1e-9)
    return float(change.max(initial=0.0))


def _rotated_offsets(
    off_mm: Points3, axis: Vector3, angles_rad: Float64[np.ndarray, " n"]
) -> Points3:
    """Vectors rotated about an axis, each by its own angle (Rodrigues)."""
    along = np.outer(off_mm @ axis, axis)
    across = off_mm - along
    cosine, sine = np.cos(angles_rad)[:, None], np.sin(angles_rad)[:, None]
    return along + cosine * across + sine * np.cross(axis, across)


def _upward(anatomy: Anatomy, joint: Joint) -> Vector3:
    """Unit vector towards the part above the ceiling; zero where there is none."""
    if joint.below is None or joint.knee is None:
        return np.zeros(3)
    return _unit(anatomy.at(joint.knee, joint.turn) - anatomy.at(joint.below, joint.turn))


def _across_axis(vector: Vector3, axis: Vector3) -> Vector3:
    return vector - axis * (vector @ axis)


def _unit(vector: Vector3) -> Vector3:
    return vector / max(float(np.linalg.norm(vector)), 1e-12)
