"""Where evaluations are tested: the warehouse, and views of it that are drawn once."""

from pathlib import Path

from safe_passage.evaluation.setting import Setting

CONFIG = Path(__file__).resolve().parents[2] / "config"
SETTING = Setting.of(CONFIG)
