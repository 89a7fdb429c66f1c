// What the fuzz targets of loaders share: bytes as a file in memory.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

// Loads the bytes as a file. Only std::runtime_error that names the file is an answer; all else that
// is thrown ends the process, which the fuzzer reports.
template <typename Load>
int load_bytes(const std::uint8_t* data, std::size_t size, const char* ending, Load load) {
  static const std::string path = "/dev/shm/fuzz-" + std::to_string(getpid()) + ending;
  static const int at_exit = std::atexit([] { unlink(path.c_str()); });
  (void)at_exit;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    load(path);
  } catch (const std::runtime_error& error) {
    if (std::string(error.what()).find(path) == std::string::npos) std::abort();
  }
  return 0;
}
