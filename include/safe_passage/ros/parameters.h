// Reads a node's private parameters into a plain struct: range-checked, and no unknown key
// accepted.
#pragma once

#include <ros/ros.h>

#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace safe_passage {

struct Range {
  double least, most;
};

class Parameters {
 public:
  explicit Parameters(const ros::NodeHandle& private_node) : node_(private_node) {
    known_.insert("diagnostic_period");  // belongs to diagnostic_updater
  }

  // Keeps `value` as the default where the parameter is not set.
  template <typename T>
  void read(const std::string& name, T& value) {
    known_.insert(name);
    XmlRpc::XmlRpcValue raw;
    if (node_.getParam(name, raw) && !node_.getParam(name, value)) fail(name, "has the wrong type");
  }

  template <typename T>
  void read(const std::string& name, T& value, Range range, const std::string& unit) {
    read(name, value);
    // Written so that NaN fails too.
    if (!(value >= range.least && value <= range.most)) {
      std::ostringstream message;
      message << "is " << value << ", must lie in [" << range.least << ", " << range.most << "] "
              << unit;
      fail(name, message.str());
    }
  }

  void read_choice(const std::string& name, std::string& value,
                   const std::set<std::string>& choices) {
    read(name, value);
    if (choices.count(value)) return;
    std::string listed;
    for (const auto& choice : choices) listed += (listed.empty() ? "" : ", ") + choice;
    fail(name, "is '" + value + "', must be one of: " + listed);
  }

  // Call after the last read: a misspelt key must not pass as the default.
  void refuse_unknown() const {
    const std::string prefix = node_.getNamespace() + "/";
    std::vector<std::string> names;
    node_.getParamNames(names);
    for (const auto& name : names) {
      if (name.compare(0, prefix.size(), prefix) != 0) continue;
      const std::string key = name.substr(prefix.size());
      if (!known_.count(key)) fail(key, "is not a parameter of this node");
    }
  }

  [[noreturn]] void fail(const std::string& name, const std::string& why) const {
    throw std::runtime_error("parameter " + node_.resolveName(name) + " " + why);
  }

 private:
  ros::NodeHandle node_;
  std::set<std::string> known_;
};

}  // namespace safe_passage
