// Which figures go into which plot.
#pragma once
#include <string>
#include <vector>

#include "culling/report/bench_summary.h"

namespace culld::report {

/// The summaries of a scene's runs, in their order, and which of them nothing beats in both time
/// and excess without having broken a promise.
struct SceneRows {
  explicit SceneRows(const SceneFigures& figures);
  const SceneFigures& scene;
  std::vector<RunSummary> rows;
  std::vector<bool> on_front;
  /// Index of the run of that method at the first image, without limit.
  std::size_t unlimited(std::size_t method) const { return method; }
};

/// The marker of a method: the same in all plots of a report.
std::size_t styleIndex(const SceneFigures& scene, std::size_t method);

std::string missedPlot(const SceneRows& rows);
std::string missedPxPlot(const SceneRows& rows);
std::string excessPlot(const SceneRows& rows);
std::string pathPlot(const SceneRows& rows);
std::string stagesPlot(const SceneRows& rows);
std::string memoryPlot(const SceneRows& rows);
std::string preparePlot(const SceneRows& rows);

/// Over all scenes, at the first image and without limit.
std::string excessOverview(const std::vector<SceneRows>& scenes);
std::string costOverview(const std::vector<SceneRows>& scenes);
std::string timeOverview(const std::vector<SceneRows>& scenes);

inline constexpr const char* kLeftOutColor = "#0072b2";
inline constexpr const char* kKeptColor = "#e69f00";
inline constexpr const char* kVisibleColor = "#009e73";
inline constexpr const char* kPreparedColor = "#0072b2";
inline constexpr const char* kViewColor = "#56b4e9";

}  // namespace culld::report
