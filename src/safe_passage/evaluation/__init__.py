"""How well did it do: datasets with truth, and the papers' metrics."""
