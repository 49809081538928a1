#include "server/machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <thread>

#include "commit.h"
#include "culling/core/simd.h"
#include "server/build_info.h"

namespace culld {
namespace {

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(':');
    if (line.rfind("model name", 0) != 0 || colon == std::string::npos) continue;
    const auto name = line.find_first_not_of(" \t", colon + 1);
    if (name != std::string::npos) return line.substr(name);
  }
  return "unknown";
}

std::string memory() {
  const double pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
  const double bytes = pages * static_cast<double>(sysconf(_SC_PAGESIZE));
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f GiB", bytes / (1U << 30U));
  return text.data();
}

std::string systemName() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return std::string(name.sysname) + " " + name.release + " " + name.machine;
}

std::string compiler() {
#ifdef __clang__
  return __VERSION__;
#else
  return std::string("g++ ") + __VERSION__;
#endif
}

std::string build() {
#ifdef NDEBUG
  return "optimized, without assertions";
#else
  return "with assertions";
#endif
}

std::string nowUtc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &parts);
  return text.data();
}

}  // namespace

std::vector<std::pair<std::string, std::string>> machineFacts() {
  return {
      {"processor", processor()},   {"cores", std::to_string(std::thread::hardware_concurrency())},
      {"memory", memory()},         {"system", systemName()},
      {"simd", activeSimdTarget()}, {"compiler", compiler()},
      {"build", build()},           {"version", server::serverName()},
      {"commit", kCommit},          {"date", nowUtc()}};
}

std::string machineLoad() {
  double load = 0.0;
  if (getloadavg(&load, 1) != 1) return "unknown";
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.2f on %u cores", load,
                std::thread::hardware_concurrency());
  return text.data();
}

}  // namespace culld
