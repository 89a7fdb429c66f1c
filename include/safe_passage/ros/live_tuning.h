// Serves some of a node's parameters by dynamic_reconfigure, to be changed while it runs; twin of
// ros/live_tuning.py. Names, ranges and units are those of the node's own reader (parameters.h).
#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/ros.h>

#include <functional>
#include <mutex>
#include <set>
#include <string>

#include "safe_passage/ros/parameters.h"

namespace safe_passage {

namespace tuning {

using dynamic_reconfigure::Config;

template <typename List, typename T>
void append(List& list, const std::string& name, const T& value) {
  typename List::value_type entry;
  entry.name = name;
  entry.value = value;
  list.push_back(entry);
}

// A list is not served.
inline void append(Config& config, const std::string& name, const ParameterValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) append(config.bools, name, *flag);
  if (const auto* whole = std::get_if<int>(&value)) append(config.ints, name, *whole);
  if (const auto* number = std::get_if<double>(&value)) append(config.doubles, name, *number);
  if (const auto* text = std::get_if<std::string>(&value)) append(config.strs, name, *text);
}

inline ParameterValues values_of(const Config& config) {
  ParameterValues values;
  for (const auto& one : config.bools) values[one.name] = static_cast<bool>(one.value);
  for (const auto& one : config.ints) values[one.name] = static_cast<int>(one.value);
  for (const auto& one : config.doubles) values[one.name] = static_cast<double>(one.value);
  for (const auto& one : config.strs) values[one.name] = std::string(one.value);
  return values;
}

// A bound, as a value of the parameter's type.
inline ParameterValue bound(const ParameterValue& like, double limit, bool flag) {
  if (std::holds_alternative<bool>(like)) return flag;
  if (std::holds_alternative<int>(like)) return static_cast<int>(limit);
  if (std::holds_alternative<std::string>(like)) return std::string();
  return limit;
}

// As dynamic_reconfigure's clients read it: a list of names to choose from.
inline std::string edit_method(const ParameterDescription& one) {
  if (one.choices.empty()) return "";
  std::string listed;
  for (const auto& choice : one.choices)
    listed += (listed.empty() ? "" : ", ") +
              ("{'name': '" + choice + "', 'value': '" + choice + "', 'type': 'str', ") +
              "'description': ''}";
  return "{'enum_description': '" + one.name + "', 'enum': [" + listed + "]}";
}

inline dynamic_reconfigure::ParamDescription described(const ParameterDescription& one) {
  static const char* const kTypes[] = {"bool", "int", "double", "str"};
  dynamic_reconfigure::ParamDescription told;
  told.name = one.name;
  told.type = kTypes[one.preset.index()];
  told.level = 1;
  told.description = one.unit.empty() ? "" : "[" + one.unit + "]";
  told.edit_method = edit_method(one);
  return told;
}

}  // namespace tuning

// A request is applied as a whole set of parameters, read by the node's own reader, or refused with
// a message: the values in force stay, and are told back. Nothing is clamped.
template <typename T>
class LiveTuning {
 public:
  using Read = std::function<T(Parameters&)>;
  using Apply = std::function<void(const T&)>;

  // Reads the parameters; throws what `read` throws. `names`: of those that may be changed.
  // `apply` is called in the thread of the node's callbacks.
  LiveTuning(const ros::NodeHandle& private_node, Read read, std::set<std::string> names,
             Apply apply)
      : node_(private_node),
        read_(std::move(read)),
        names_(std::move(names)),
        apply_(std::move(apply)) {
    Parameters from(node_);
    parameters_ = read_(from);
    keep(from);
  }

  const T& parameters() const { return parameters_; }

  // Requests are taken from now on.
  void serve() {
    descriptions_pub_ =
        node_.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true);
    updates_pub_ = node_.advertise<tuning::Config>("parameter_updates", 1, true);
    descriptions_pub_.publish(description());
    tell();
    service_ = node_.advertiseService("set_parameters", &LiveTuning::on_request, this);
  }

 private:
  bool on_request(dynamic_reconfigure::Reconfigure::Request& request,
                  dynamic_reconfigure::Reconfigure::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex_);
    try {
      change(tuning::values_of(request.config));
    } catch (const std::runtime_error& error) {
      ROS_WARN("refused, nothing is changed: %s", error.what());
    }
    response.config = tell();
    return true;
  }

  void change(const ParameterValues& wanted) {
    ParameterValues values = values_;
    for (const auto& [name, value] : wanted) {
      if (!names_.count(name))
        throw std::runtime_error("parameter " + name + " cannot be changed while it runs");
      values[name] = value;
    }
    Parameters from(node_, std::move(values));
    parameters_ = read_(from);
    keep(from);
    apply_(parameters_);
    for (const auto& [name, value] : wanted) ROS_INFO("changed: %s", name.c_str());
  }

  void keep(const Parameters& from) {
    described_ = from.described();
    for (const auto& one : described_) values_[one.name] = one.value;
  }

  // The values in force, to clients and parameter server.
  tuning::Config tell() {
    tuning::Config config;
    for (const auto& one : described_) {
      if (!names_.count(one.name)) continue;
      tuning::append(config, one.name, one.value);
      std::visit([&](const auto& value) { node_.setParam(one.name, value); }, one.value);
    }
    dynamic_reconfigure::GroupState group;
    group.name = "Default";
    group.state = true;
    config.groups.push_back(group);
    updates_pub_.publish(config);
    return config;
  }

  dynamic_reconfigure::ConfigDescription description() const {
    dynamic_reconfigure::ConfigDescription told;
    told.groups.resize(1);
    told.groups[0].name = "Default";
    for (const auto& one : described_) {
      if (!names_.count(one.name)) continue;
      told.groups[0].parameters.push_back(tuning::described(one));
      tuning::append(told.min, one.name, tuning::bound(one.preset, one.range.least, false));
      tuning::append(told.max, one.name, tuning::bound(one.preset, one.range.most, true));
      tuning::append(told.dflt, one.name, one.preset);
    }
    return told;
  }

  ros::NodeHandle node_;
  const Read read_;
  const std::set<std::string> names_;
  const Apply apply_;
  std::mutex mutex_;  // guards what follows, once it serves
  T parameters_;
  std::vector<ParameterDescription> described_;
  ParameterValues values_;
  ros::Publisher descriptions_pub_, updates_pub_;
  ros::ServiceServer service_;
};

}  // namespace safe_passage
