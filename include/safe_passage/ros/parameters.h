// Reads a node's private parameters into a plain struct: range-checked, and no unknown key
// accepted. What it read it can describe.
#pragma once

#include <ros/ros.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace safe_passage {

struct Range {
  double least, most;
};

using ParameterValue = std::variant<bool, int, double, std::string, std::vector<double>>;
using ParameterValues = std::map<std::string, ParameterValue>;

struct ParameterDescription {
  std::string name;
  ParameterValue preset, value;  // where it is not set; as read
  Range range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::string unit;
  std::set<std::string> choices = {};  // empty: any
};

class Parameters {
 public:
  explicit Parameters(const ros::NodeHandle& private_node) : node_(private_node) {
    known_.insert("diagnostic_period");  // belongs to diagnostic_updater
  }

  // Reads `values` in place of the parameter server, which is not asked.
  Parameters(const ros::NodeHandle& private_node, ParameterValues values)
      : node_(private_node), values_(std::move(values)), is_given_(true) {}

  // Keeps `value` as the default where the parameter is not set.
  template <typename T>
  void read(const std::string& name, T& value) {
    const T preset = value;
    known_.insert(name);
    if (is_given_)
      take(name, value);
    else
      ask(name, value);
    ParameterDescription description;
    description.name = name;
    description.preset = preset;
    description.value = value;
    described_.push_back(description);
  }

  template <typename T>
  void read(const std::string& name, T& value, Range range, const std::string& unit) {
    read(name, value);
    described_.back().range = range;
    described_.back().unit = unit;
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
    described_.back().choices = choices;
    if (choices.count(value)) return;
    std::string listed;
    for (const auto& choice : choices) listed += (listed.empty() ? "" : ", ") + choice;
    fail(name, "is '" + value + "', must be one of: " + listed);
  }

  // [[x, y], ...]; empty where it is not set. Always the parameter server's: not for live tuning.
  std::vector<std::pair<double, double>> read_points(const std::string& name) {
    known_.insert(name);
    XmlRpc::XmlRpcValue raw;
    std::vector<std::pair<double, double>> points;
    if (!node_.getParam(name, raw)) return points;
    const auto number = [&](XmlRpc::XmlRpcValue& value) {
      const bool whole = value.getType() == XmlRpc::XmlRpcValue::TypeInt;
      if (!whole && value.getType() != XmlRpc::XmlRpcValue::TypeDouble)
        fail(name, "must be a list of points [x, y]");
      const double found = whole ? static_cast<int>(value) : static_cast<double>(value);
      if (!(std::abs(found) < 1e6)) fail(name, "is not finite");
      return found;
    };
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeArray)
      fail(name, "must be a list of points [x, y]");
    for (int i = 0; i < raw.size(); ++i) {
      if (raw[i].getType() != XmlRpc::XmlRpcValue::TypeArray || raw[i].size() != 2)
        fail(name, "must be a list of points [x, y]");
      points.emplace_back(number(raw[i][0]), number(raw[i][1]));
    }
    return points;
  }

  // Call after the last read: a misspelt key must not pass as the default.
  void refuse_unknown() const {
    if (is_given_) return;
    const std::string prefix = node_.getNamespace() + "/";
    std::vector<std::string> names;
    node_.getParamNames(names);
    for (const auto& name : names) {
      if (name.compare(0, prefix.size(), prefix) != 0) continue;
      const std::string key = name.substr(prefix.size());
      if (!known_.count(key)) fail(key, "is not a parameter of this node");
    }
  }

  // Everything read so far, in its order.
  const std::vector<ParameterDescription>& described() const { return described_; }

  [[noreturn]] void fail(const std::string& name, const std::string& why) const {
    throw std::runtime_error("parameter " + node_.resolveName(name) + " " + why);
  }

 private:
  template <typename T>
  void ask(const std::string& name, T& value) const {
    XmlRpc::XmlRpcValue raw;
    if (node_.getParam(name, raw) && !node_.getParam(name, value)) fail(name, "has the wrong type");
  }

  template <typename T>
  void take(const std::string& name, T& value) const {
    const auto found = values_.find(name);
    if (found == values_.end()) return;
    if (const T* given = std::get_if<T>(&found->second)) {
      value = *given;
      return;
    }
    if constexpr (std::is_same_v<T, double>) {  // 1 is a number, too
      if (const int* whole = std::get_if<int>(&found->second)) {
        value = *whole;
        return;
      }
    }
    fail(name, "has the wrong type");
  }

  ros::NodeHandle node_;
  ParameterValues values_;
  bool is_given_ = false;
  std::set<std::string> known_;
  std::vector<ParameterDescription> described_;
};

}  // namespace safe_passage
