"""Report: pictures, figures and pages, of a reconstruction, its accuracy, a lens or a shape."""
