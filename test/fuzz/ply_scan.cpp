// Scans of .ply files: segment_scan, replay_scan.
#include "file_target.h"
#include "safe_passage/scan_segmentation/cloud_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return load_bytes(data, size, ".ply", [](const std::string& path) {
    const auto cloud = safe_passage::scan_segmentation::read_cloud(path);
    const auto points = static_cast<std::size_t>(cloud.width) * cloud.height;
    if (cloud.xyz.size() != 3 * points) std::abort();
    if (!cloud.remission.empty() && cloud.remission.size() != points) std::abort();
  });
}
