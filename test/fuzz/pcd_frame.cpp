// Coloured, organised clouds of .pcd files: replay_camera, evaluate.
#include "file_target.h"
#include "safe_passage/person_detection/frame_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return load_bytes(data, size, ".pcd", [](const std::string& path) {
    const auto frame = safe_passage::person_detection::load_pcd(path);
    if (frame.xyz.size() != frame.bgr.size() || frame.xyz.empty()) std::abort();
  });
}
