"""Human safety: persons -> safety areas -> merged scan -> costmap (the C++ libraries' python side)."""
