# Sourced by tools/test: the C++ code built and run with gcc's sanitizers, beside the ordinary build.

# $1: sanitizers, the rest: targets. What is not built here is taken from the ordinary devel space.
sanitized_build() {
  local kind=$1 into=$ws/sanitize/$1
  shift
  step "build with -fsanitize=$kind"
  mkdir -p "$into"
  if ! {
    cmake -S "$root" -B "$into/build" -Wno-dev -DCATKIN_DEVEL_PREFIX="$into/devel" -DCMAKE_BUILD_TYPE=None \
      -DCMAKE_CXX_FLAGS="-fsanitize=$kind -fno-sanitize-recover=all -fno-omit-frame-pointer -g1 -O1" \
      -DPYTHON_EXECUTABLE="$venv/bin/python3" -DPython3_EXECUTABLE="$venv/bin/python3" &&
      cmake --build "$into/build" -j2 --target "$@"
  } >"$into/build.log" 2>&1; then
    grep -nE 'rror' "$into/build.log" | head -20
    echo "build failed: the whole log is $into/build.log"
    exit 1
  fi
}

# Memory and undefined behaviour: a finding ends the process that has it.
test_memory() {
  local kind=address,undefined
  local into=$ws/sanitize/$kind/devel/lib
  sanitized_build "$kind" test_person_detection test_person_conversions test_safety_area \
    _monitoring _person_detection _safety_area _scan_segmentation _separation
  step "tests with -fsanitize=$kind"
  "$into/safe_passage/test_person_detection" --gtest_brief=1
  "$into/safe_passage/test_person_conversions" --gtest_brief=1
  "$into/safe_passage/test_safety_area" --gtest_brief=1
  # python is not built with it: the libraries come first, and what python never frees is no leak of ours
  LD_PRELOAD="$(gcc -print-file-name=libasan.so) $(gcc -print-file-name=libubsan.so)" \
    ASAN_OPTIONS=detect_leaks=0 PYTHONPATH="$into/python3/dist-packages:$PYTHONPATH" \
    python3 -m pytest -q -s -p no:cacheprovider "$root"/test/unit/{scan_segmentation,separation} \
    "$root"/test/unit/monitoring/test_mon_alignment.py \
    "$root"/test/unit/test_{person_detection,safety_area,yolo_models}.py
}

# Races in the nodes that have several threads. ROS itself is not built with it, so its own counting of
# references looks like races: only accesses of our code count. So do OpenCV's threads: on one core it has none.
# Nor does the node test's verdict count: it is many times slower.
test_threads() {
  local into=$ws/sanitize/thread node
  sanitized_build thread safety_area_merger person_detector
  for node in safety_area_merger person_detector; do
    step "$node with -fsanitize=thread"
    rm -rf "$into/races" && mkdir "$into/races"
    (
      set +u
      # shellcheck disable=SC1091
      source "$into/devel/setup.bash"
      TSAN_OPTIONS="exitcode=0 log_path=$into/races/log" \
        taskset --cpu-list 0 rostest --text "$root/test/node/$node.test" >"$into/test.log" 2>&1
    ) || true
    grep -E '^Ran [0-9]+ tests' "$into/test.log"
    cat "$into/races"/* /dev/null | races_of_ours >"$into/$node.races"
    if [ -s "$into/$node.races" ]; then
      sed -n 1,60p "$into/$node.races"
      echo "races: $into/$node.races"
      exit 1
    fi
  done
}

# Of reports on stdin those in whose accesses our code is, and not only in how the threads were made.
races_of_ours() {
  awk -v root="$root/" 'BEGIN { RS = "==================\n" }
    { split($0, part, /\n  (Location|Mutex|Thread|As if)/); if (index(part[1], root)) print }'
}
