#include "safe_passage/scan_segmentation/cloud_file.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/common/io.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "safe_passage/core/pcd_file.h"
#include "safe_passage/core/ply_header.h"

namespace safe_passage::scan_segmentation {
namespace {

const pcl::PCLPointField* find(const pcl::PCLPointCloud2& cloud,
                               std::initializer_list<const char*> names) {
  for (const char* name : names)
    for (const auto& field : cloud.fields)
      if (field.name == name) return &field;
  return nullptr;
}

template <typename T>
double as(const std::uint8_t* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

double value(const pcl::PCLPointField& field, const std::uint8_t* point) {
  const std::uint8_t* at = point + field.offset;
  switch (field.datatype) {
    case pcl::PCLPointField::INT8:
      return as<std::int8_t>(at);
    case pcl::PCLPointField::UINT8:
      return as<std::uint8_t>(at);
    case pcl::PCLPointField::INT16:
      return as<std::int16_t>(at);
    case pcl::PCLPointField::UINT16:
      return as<std::uint16_t>(at);
    case pcl::PCLPointField::INT32:
      return as<std::int32_t>(at);
    case pcl::PCLPointField::UINT32:
      return as<std::uint32_t>(at);
    case pcl::PCLPointField::INT64:
      return as<std::int64_t>(at);
    case pcl::PCLPointField::UINT64:
      return as<std::uint64_t>(at);
    case pcl::PCLPointField::BOOL:
      return *at != 0;
    case pcl::PCLPointField::FLOAT32:
      return as<float>(at);
    case pcl::PCLPointField::FLOAT64:
      return as<double>(at);
    default:
      throw std::runtime_error(field.name);  // not met: see check()
  }
}

void check(const pcl::PCLPointField& field, const pcl::PCLPointCloud2& cloud,
           const std::string& path) {
  const auto size = static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
  if (size == 0)
    throw std::runtime_error(path + ": field " + field.name + " is of an unknown type");
  if (field.offset + size > cloud.point_step)
    throw std::runtime_error(path + ": field " + field.name + " lies outside of its points");
}

// PCL 1.13 crashes on a file without a header: it is read by itself first.
template <typename Reader>
void read(Reader reader, const std::string& path, pcl::PCLPointCloud2* cloud,
          Eigen::Vector4f* origin) try {
  Eigen::Quaternionf orientation;
  int version = 0, type = 0;
  unsigned int index = 0;
  if (reader.readHeader(path, *cloud, *origin, orientation, version, type, index) < 0)
    throw std::runtime_error(path + ": its header cannot be read");
  if (!find(*cloud, {"x"}) || !find(*cloud, {"y"}) || !find(*cloud, {"z"}))
    throw std::runtime_error(path + ": lacks fields x, y, z");
  if (reader.read(path, *cloud, *origin, orientation, version) < 0)
    throw std::runtime_error(path + ": its points cannot be read");
} catch (const std::logic_error& error) {  // PCL's own, of headers that contradict themselves
  throw std::runtime_error(path + ": cannot be read: " + error.what());
} catch (const std::bad_alloc&) {
  throw std::runtime_error(path + ": too large");
}

}  // namespace

CloudFile read_cloud(const std::string& path) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // the exception says it
  pcl::PCLPointCloud2 cloud;
  Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  if (std::filesystem::path(path).extension() == ".ply") {
    refuse_lying_ply(path);
    read(pcl::PLYReader(), path, &cloud, &origin);
  } else {
    refuse_unsound_pcd(path);
    read(pcl::PCDReader(), path, &cloud, &origin);
  }
  const auto *x = find(cloud, {"x"}), *y = find(cloud, {"y"}), *z = find(cloud, {"z"});
  const auto* remission = find(cloud, {"intensity", "remission", "reflectance", "i"});
  for (const auto* field : {x, y, z, remission})
    if (field) check(*field, cloud, path);
  const std::size_t count = static_cast<std::size_t>(cloud.width) * cloud.height;
  if (cloud.data.size() < count * cloud.point_step)
    throw std::runtime_error(path + ": it ends before its last point");
  CloudFile file{static_cast<int>(cloud.width),
                 static_cast<int>(cloud.height),
                 {},
                 {},
                 {origin.x(), origin.y(), origin.z()}};
  file.xyz.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* point = cloud.data.data() + i * cloud.point_step;
    for (const auto* field : {x, y, z}) file.xyz.push_back(value(*field, point));
    if (remission) file.remission.push_back(value(*remission, point));
  }
  return file;
}

}  // namespace safe_passage::scan_segmentation
