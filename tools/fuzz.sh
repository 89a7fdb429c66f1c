# Sourced by tools/test: coverage-guided fuzzing (clang's libFuzzer) of C++ loaders and converters with
# address and undefined sanitizers. Guided by our own code and headers: libraries are not built with it.

fuzz_targets=(pcd_scan ply_scan pcd_frame cloud_message image_message person_message scan_message)

# $1: target.
fuzz_build() {
  local sources=("$root/test/fuzz/$1.cpp") packages=(pcl_io eigen3)
  case $1 in
    pcd_scan | ply_scan) sources+=("$root/src/scan_segmentation/cloud_file.cpp") ;;
    pcd_frame) sources+=("$root/src/person_detection/frame_io.cpp") packages+=(opencv4) ;;
    cloud_message) sources+=("$root/src/ros/person_conversions.cpp" "$root/src/person_detection/ground_plane.cpp") packages+=(opencv4 roscpp) ;;
    image_message) sources+=("$root/src/ros/person_conversions.cpp" "$root/src/person_detection/"{ground_plane,frame_io}.cpp) packages+=(opencv4 cv_bridge roscpp) ;;
    person_message) sources+=("$root/src/safety_area/"{person_memory,pipeline,scan_merger}.cpp "$root/src/separation/shape_distance.cpp") packages+=(roscpp) ;;
    scan_message) sources+=("$root/src/safety_area/scan_merger.cpp" "$root/src/separation/shape_distance.cpp") packages+=(roscpp) ;;
  esac
  local flags libraries
  read -ra flags <<<"$(pkg-config --cflags "${packages[@]}")"
  read -ra libraries <<<"$(pkg-config --libs "${packages[@]}")"
  "$fuzz_clang" -std=c++17 -g -O1 -fno-omit-frame-pointer -fsanitize=fuzzer,address,undefined \
    -fno-sanitize-recover=all -I"$root/include" -I"$ws/devel/include" "${flags[@]}" -w \
    "${sources[@]}" -o "$fuzz_folder/$1" "${libraries[@]}" -lpthread
}

# $1: seconds for each target. What is found stays in the workspace, and is told.
fuzz() {
  local seconds=$1 target failed=0
  fuzz_folder=$ws/fuzz
  fuzz_clang=$(command -v clang++ || command -v clang++-14) || {
    echo "tools/test --fuzz needs clang with its run-time libraries: apt-get install clang-14 libclang-rt-14-dev"
    exit 1
  }
  mkdir -p "$fuzz_folder/found"
  python3 "$root/test/fuzz/seeds.py" "$fuzz_folder/corpus"
  for target in "${fuzz_targets[@]}"; do
    step "fuzz $target for $seconds s"
    fuzz_build "$target"
    ASAN_OPTIONS=detect_leaks=0 "$fuzz_folder/$target" -max_total_time="$seconds" -max_len=4096 -timeout=20 -rss_limit_mb=1024 \
      -print_final_stats=1 -artifact_prefix="$fuzz_folder/found/$target-" \
      "$fuzz_folder/corpus/$target" >"$fuzz_folder/$target.log" 2>&1 || failed=1
    grep -E 'ERROR:|SUMMARY|runtime error|Test unit written|what\(\)' "$fuzz_folder/$target.log" || true
    grep -E 'cov: ' "$fuzz_folder/$target.log" | tail -1 || true
    grep -E 'number_of_executed_units|peak_rss' "$fuzz_folder/$target.log" || true
  done
  return "$failed"
}
