"""What every room may import: errors, parameters, geometry, depth images."""
