"""Record: a shape's page and PDF for the file."""
