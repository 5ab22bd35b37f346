"""Figures: what each product says about accuracy, one file a subject, plain values for JSON."""

from limbgram.report.accuracy.figures.images import image_figures
from limbgram.report.accuracy.figures.lengths import length_figures
from limbgram.report.accuracy.figures.lens import camera_figures, pose_figures
from limbgram.report.accuracy.figures.network import network_figures
from limbgram.report.accuracy.figures.residuals import residual_figures
from limbgram.report.accuracy.figures.surface import surface_figures
from limbgram.report.accuracy.figures.truth import truth_figures

__all__ = [
    "camera_figures",
    "image_figures",
    "length_figures",
    "network_figures",
    "pose_figures",
    "residual_figures",
    "surface_figures",
    "truth_figures",
]
