// Error against run time: every method at every setting over a scene's cameras, held against the
// oracle (docs/bench.md says what each figure means). One scene at a time; reports are made of the
// figures alone, so that scenes can be let go of.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "culling/oracle/oracle.h"
#include "culling/report/statistics.h"

namespace culld {

/// What is turned from run to run.
struct BenchSetting {
  std::optional<ImageSize> image;    ///< none: each camera's own
  std::chrono::nanoseconds time{0};  ///< per camera; 0: no limit
  std::string name() const;          ///< "640x360, 500 us", "no limit"
};

struct BenchMethod {
  std::string name;
  const Method* method = nullptr;
  std::size_t style = 0;  ///< how it looks in plots: the same number in all scenes
};

struct RefusedMethod {
  std::string name, why;  ///< the scene is not for it
};

/// REQUIRES: methods and cameras not empty, `numbers` one per camera, `baseline` one of methods.
struct BenchScene {
  std::string name;
  SnapshotPtr scene;
  std::vector<Camera> cameras;
  std::vector<std::size_t> numbers;  ///< of the cameras, in their file
  std::vector<BenchMethod> methods;
  std::size_t baseline = 0;  ///< the method that only looks at the frustum
  std::vector<RefusedMethod> refused;
};

struct BenchOptions {
  std::vector<ImageSize> images;                 ///< none: each camera's own size
  std::vector<std::chrono::nanoseconds> limits;  ///< 0, no limit, is always measured
  std::uint32_t repeat = 5;
  OracleOptions truth;
  /// Bytes of a set of ids on the wire, as a change of the set before it (empty: sent whole).
  std::function<std::size_t(std::span<const ObjectId> before, std::span<const ObjectId> now)>
      wire_bytes;
  std::function<void(std::size_t done, std::size_t total)> progress;  ///< in cameras; may be none
  const Clock& clock = steadyClock();
};

/// One answered camera, over all repetitions.
struct CameraFigures {
  double answered = 0.0;                          ///< mean
  std::uint32_t missed = 0, missed_subpixel = 0;  ///< of the worst repetition
  double missed_px = 0.0;                         ///< of the worst repetition
  std::optional<double> said_px;    ///< an approximate answer's bound or estimate, first repetition
  bool exceeded = false;            ///< and it missed more, in any repetition
  double work_us = 0.0;             ///< counted and priced (CullStats::work), mean
  std::uint32_t out_of_budget = 0;  ///< repetitions cut short
  report::Spread time_us;           ///< over the repetitions
  std::size_t answer_bytes = 0,
              change_bytes = 0;  ///< first repetition: whole; after the camera before
  CullStats stats;               ///< first repetition
};

struct TruthFigures {
  std::size_t camera = 0;  ///< number in the cameras file
  std::size_t in_frustum = 0, visible = 0, subpixel = 0;
  std::uint64_t rays = 0;
  double unfound = 0.0;  ///< estimate: how many more one more round of aimed rays would find
};

/// A promise that an answer did not keep.
struct Breach {
  std::string scene, method, setting;
  std::size_t camera = 0;
  std::string what;  ///< "object 17 (node 5, instance 2) is visible in 31.5 px and was left out"
  std::string line() const;
};

struct BenchRun {
  std::size_t method = 0, setting = 0;  ///< indices in SceneFigures
  std::vector<CameraFigures> cameras;
  std::uint64_t breaches = 0;  ///< answers that broke their promise
  std::optional<Breach> first_breach;
  std::map<std::string, std::uint64_t> made_by;  ///< answers, if the method chooses among others
  std::size_t view_bytes = 0;  ///< what a view keeps between cameras, by the allocator's books
};

struct MethodFigures {
  std::string name, source, needs;
  std::size_t style = 0;
  Guarantee guarantee = Guarantee::kConservative;
  double prepare_ms = 0.0;
  std::size_t prepared_bytes = 0;
};

struct SceneFigures {
  std::string name;
  std::uint64_t objects = 0, triangles = 0, scene_bytes = 0;  ///< objects that can be answered
  std::vector<MethodFigures> methods;
  std::vector<RefusedMethod> refused;
  std::size_t baseline = 0;
  std::vector<BenchSetting> settings;             ///< images outermost; within each, no limit first
  std::size_t limits = 1;                         ///< settings per image
  std::vector<std::vector<TruthFigures>> truths;  ///< per image, then per camera
  std::vector<BenchRun> runs;                     ///< by setting, then by method
  std::string picture_png, picture_title;         ///< the worst frame; bytes of a PNG
  std::uint32_t repeat = 0;

  const std::vector<TruthFigures>& truthOf(const BenchRun& run) const;
  /// The run of the baseline at the same image and without limit.
  const BenchRun& baselineOf(const BenchRun& run) const;
};

/// Truth first, then the methods in turn, so that noise hits all alike. Memory does not grow with
/// the cameras but for their figures. ERROR: kUnavailable of the oracle, errors of prepare().
Result<SceneFigures> benchScene(const BenchScene& scene, const BenchOptions& options);

/// What a reader needs to measure the same again, as (name, value).
using BenchFacts = std::vector<std::pair<std::string, std::string>>;

struct BenchReport {
  BenchFacts facts;
  std::vector<SceneFigures> scenes;
  std::vector<Breach> breaches() const;  ///< the first one of each run that has any
  /// The first line of every report.
  std::string verdict() const;
};

/// A table for the terminal, without the verdict.
std::string benchText(const BenchReport& report);
/// One row per scene, method and setting; the first line is a comment with the verdict.
std::string benchCsv(const BenchReport& report);
/// All figures, those of single cameras included.
std::string benchJson(const BenchReport& report);
/// A page that needs nothing else: tables, plots, pictures.
std::string benchHtml(const BenchReport& report);

}  // namespace culld
