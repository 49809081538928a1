// What a measurement was taken on: a figure without it cannot be compared with any other.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace culld {

/// (name, value) pairs: processor, cores, memory, system, compiler, build, version, commit, date.
std::vector<std::pair<std::string, std::string>> machineFacts();

/// The load of the last minute, as the system counts it: "1.52 of 2 cores".
std::string machineLoad();

}  // namespace culld
