"""From oriented points to triangles: Ball Pivoting, or Poisson."""
