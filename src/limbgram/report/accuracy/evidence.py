"""Evidence: the products of a finished reconstruction from which its accuracy is read."""

from dataclasses import dataclass, field

from limbgram.capture.setup import SetupCited
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.taped_girths import TapeWitnesses
from limbgram.reconstruction.targets.board import BoardDetections
from limbgram.report.accuracy.figures import length_unit

_DIGITS = 8


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """The products of a case from which its accuracy is read; nothing is computed again."""

    photos: PhotoSet
    cameras: Cameras
    """Lenses before the adjustment, with the covariance of their calibration."""
    detections: BoardDetections | None
    metric: MetricScene
    mesh: Mesh
    tapes: TapeWitnesses = field(default_factory=TapeWitnesses)
    """Girths that were taped on the limb, beside the mesh's."""
    setups: tuple[SetupCited, ...] = ()
    """Acceptance tests of the kit, one for each camera file that has a certificate."""

    __repr__ = brief

    @property
    def name(self) -> str:
        """The case's name for people, by its photos, as a folder's name is often a patient's."""
        return f"case {self.photos.digest[:_DIGITS]}"

    @property
    def unit(self) -> str:
        """Unit in which lengths are written."""
        return length_unit(self.metric.scale.unit)
