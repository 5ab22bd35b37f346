"""The names of the library, each beside the room that it comes from."""

from .capture.answer import (
    CaptureCheck as CaptureCheck,
    Coverage as Coverage,
)
from .capture.coach import check_capture as check_capture
from .capture.plan import (
    CapturePlan as CapturePlan,
    LimbForm as LimbForm,
    PlannedCamera as PlannedCamera,
    form_of as form_of,
    plain_limb as plain_limb,
    plan_capture as plan_capture,
)
from .cases.accuracy import evidence_of as evidence_of
from .cases.case_assessment import assess_case as assess_case
from .cases.capture_check import CaptureWatch as CaptureWatch, check_sources as check_sources
from .cases.folder import CaseFolder as CaseFolder
from .cases.video_frames import take_frames as take_frames
from .core.errors import Cancelled as Cancelled, LimbgramError as LimbgramError
from .core.geometry.frames import Rigid as Rigid
from .core.geometry.lens import Camera as Camera
from .core.mesh.mesh import Mesh as Mesh
from .core.run import Run as Run
from .formats import (
    AopOptions as AopOptions,
    AopReport as AopReport,
    Control as Control,
    GcodeReport as GcodeReport,
    Machine as Machine,
    ShapeFile as ShapeFile,
    admit as admit,
    in_limb_frame as in_limb_frame,
    read_limb as read_limb,
    read_machine as read_machine,
    read_shape as read_shape,
    write_aop as write_aop,
    write_dxf as write_dxf,
    write_gcode as write_gcode,
    write_glb as write_glb,
    write_limb as write_limb,
    write_limb_file as write_limb_file,
    write_machine as write_machine,
    write_obj as write_obj,
    write_ply as write_ply,
    write_r12_dxf as write_r12_dxf,
    write_3mf as write_3mf,
    write_stl as write_stl,
    write_vtp as write_vtp,
)
from .formats.camera import read_camera as read_camera, write_camera as write_camera
from .reconstruction.calibration import (
    BoardCalibration as BoardCalibration,
    Calibration as Calibration,
    CalibrationOptions as CalibrationOptions,
    calibrate as calibrate,
)
from .reconstruction.photos import (
    PhotoOptions as PhotoOptions,
    PhotoSet as PhotoSet,
    read_photos as read_photos,
)
from .reconstruction.pipeline import (
    Capture as Capture,
    PipelineOptions as PipelineOptions,
    Reconstruction as Reconstruction,
    reconstruct as reconstruct,
)
from .reconstruction.scale import KnownDistance as KnownDistance, Pick as Pick
from .reconstruction.scale.stated_lengths import TapedGirth as TapedGirth
from .reconstruction.targets import Board as Board
from .report.accuracy import (
    Assessment as Assessment,
    Evidence as Evidence,
    KnownTruth as KnownTruth,
    assess as assess,
)
from .synthetic import CaptureOptions as CaptureOptions, make_capture as make_capture
from .workbench import (
    AlignedLimb as AlignedLimb,
    Landmark as Landmark,
    Limb as Limb,
    LimbFrame as LimbFrame,
)
from .workbench.carving import CarveOptions as CarveOptions
from .workbench.compare import (
    CompareOptions as CompareOptions,
    Comparison as Comparison,
    RegistrationOptions as RegistrationOptions,
    compare as compare,
)
from .workbench.compare.over_time import (
    Series as Series,
    Visit as Visit,
    follow as follow,
    repeats as repeats,
)
from .workbench.compare.sheets import (
    SheetTrend as SheetTrend,
    SheetVisit as SheetVisit,
    follow_sheets as follow_sheets,
)
from .workbench.devices.device import Device as Device, devices as devices
from .workbench.devices.making import (
    FinishedDevice as FinishedDevice,
    Order as Order,
    Preview as Preview,
    make_device as make_device,
    preview_device as preview_device,
)
from .workbench.devices.trims import Handle as Handle
from .workbench.edits import EDITS as EDITS, Edit as Edit, do_edit as do_edit
from .workbench.frame import (
    AlignOptions as AlignOptions,
    align as align,
    with_landmarks as with_landmarks,
)
from .workbench.measures import (
    LimbMeasureOptions as LimbMeasureOptions,
    Measures as Measures,
    TapeFit as TapeFit,
    TapeReading as TapeReading,
    fit_to_tape as fit_to_tape,
    measure_limb as measure_limb,
    measure_inside as measure_inside,
)
from .workbench.measures.along import (
    AlongCentreline as AlongCentreline,
    measure_along as measure_along,
)
from .workbench.measures.sheet import (
    MeasuringSheet as MeasuringSheet,
    SheetOptions as SheetOptions,
    measuring_sheet as measuring_sheet,
)
from .workbench.recipe import (
    Recipe as Recipe,
    Replayed as Replayed,
    added as added,
    encode_recipe as encode_recipe,
    make_edit as make_edit,
    read_recipe as read_recipe,
    replay as replay,
)
from .workbench.templates import (
    Applied as Applied,
    Learned as Learned,
    LearnOptions as LearnOptions,
    Pair as Pair,
    Template as Template,
    apply_template as apply_template,
    encode_template as encode_template,
    learn as learn,
    read_template as read_template,
)
