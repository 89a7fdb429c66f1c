# Sourced by the other tools: where the workspace lives, and how to enter it.
# SAFE_PASSAGE_WS names another workspace; by default every checkout has its own under ~/.cache.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
ws=${SAFE_PASSAGE_WS:-${XDG_CACHE_HOME:-$HOME/.cache}/safe_passage/$(basename "$root")-$(printf %s "$root" | sha256sum | cut -c1-8)}
venv=$ws/venv
export SAFE_PASSAGE_DATA=${SAFE_PASSAGE_DATA:-$root/../shared/data}

step() { printf '\n==> %s\n' "$*"; }

# Everything that setup's result depends on, besides the sources, which `build` follows by itself.
setup_stamp() { cat "$root/tools/setup" "$root/tools/apt-packages.txt" "$root/tools/pip-packages.txt" | sha256sum; }

ensure_setup() {
  if [ "$(cat "$ws/.setup" 2>/dev/null)" != "$(setup_stamp)" ]; then "$root/tools/setup"; else build; fi
}

# Builds the workspace; extra arguments go to catkin_make. One build at a time.
build() {
  (
    flock 9
    cd "$ws"
    catkin_make -j2 -DPYTHON_EXECUTABLE="$venv/bin/python3" \
      -DPython3_EXECUTABLE="$venv/bin/python3" "$@" >"$ws/build.log" 2>&1 ||
      { grep -nE 'rror' "$ws/build.log" | head -20; echo "build failed: the whole log is $ws/build.log"; exit 1; }
  ) 9>"$ws/.lock"
}

enter_workspace() {
  set +u  # ROS's own scripts use unset variables
  # shellcheck disable=SC1091
  source "$ws/devel/setup.bash"
  set -u
  export PATH=$venv/bin:$PATH
}
