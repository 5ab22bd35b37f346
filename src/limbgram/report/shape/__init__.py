"""Report of the workbench: pictures of a shape for the record."""
