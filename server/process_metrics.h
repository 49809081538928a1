// What Prometheus expects every process to tell about itself, under its conventional names.
#pragma once
#include <prometheus/metric_family.h>

#include <vector>

namespace culld::server {

/// Read from /proc/self; what cannot be read is left out. THREADS: any.
std::vector<prometheus::MetricFamily> processMetrics();

}  // namespace culld::server
