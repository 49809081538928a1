#include "server/process_metrics.h"

#include <dirent.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>

namespace culld::server {
namespace {

using prometheus::MetricFamily;
using prometheus::MetricType;

MetricFamily single(const char* name, const char* help, MetricType type, double value) {
  prometheus::ClientMetric metric;
  (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  return {name, help, type, {metric}};
}

/// The fields of /proc/self/stat after the program's name, which may hold anything: proc(5) counts
/// the first of them as number 3.
std::vector<std::string> processStat() {
  std::ifstream file("/proc/self/stat");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto name_end = text.rfind(')');
  if (name_end == std::string::npos) return {};
  std::istringstream rest(text.substr(name_end + 1));
  return {std::istream_iterator<std::string>(rest), {}};
}

double seconds(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

std::optional<double> openDescriptors() {
  DIR* folder = ::opendir("/proc/self/fd");
  if (folder == nullptr) return std::nullopt;
  double count = -3;  // ".", ".." and the one that reads
  while (::readdir(folder) != nullptr) ++count;
  ::closedir(folder);
  return count;
}

}  // namespace

std::vector<MetricFamily> processMetrics() {
  constexpr std::size_t kStart = 22 - 3;
  constexpr std::size_t kVirtualBytes = 23 - 3;
  constexpr std::size_t kResidentPages = 24 - 3;
  std::vector<MetricFamily> out;
  const auto add = [&out](const char* name, const char* help, MetricType type, double value) {
    out.push_back(single(name, help, type, value));
  };
  add("process_cpu_seconds_total", "User and system time", MetricType::Counter,
      seconds(CLOCK_PROCESS_CPUTIME_ID));
  const auto stat = processStat();
  if (stat.size() > kResidentPages) {
    const auto field = [&stat](std::size_t i) { return std::strtod(stat[i].c_str(), nullptr); };
    add("process_virtual_memory_bytes", "Address space", MetricType::Gauge, field(kVirtualBytes));
    add("process_resident_memory_bytes", "Memory held", MetricType::Gauge,
        field(kResidentPages) * static_cast<double>(::sysconf(_SC_PAGESIZE)));
    // Once: the two clocks drift apart, and a start that changes would be taken for a restart.
    static const double kStarted = seconds(CLOCK_REALTIME) - seconds(CLOCK_BOOTTIME) +
                                   field(kStart) / static_cast<double>(::sysconf(_SC_CLK_TCK));
    add("process_start_time_seconds", "Start, since the epoch", MetricType::Gauge, kStarted);
  }
  if (const auto open = openDescriptors()) {
    add("process_open_fds", "Open file descriptors", MetricType::Gauge, *open);
  }
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    add("process_max_fds", "Open file descriptors that this process may have", MetricType::Gauge,
        static_cast<double>(limit.rlim_cur));
  }
  return out;
}

}  // namespace culld::server
