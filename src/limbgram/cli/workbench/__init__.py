"""The workbench: commands on a shape."""
