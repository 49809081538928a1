// Pieces of the HTML report.
#pragma once
#include <string>
#include <vector>

#include "culling/report/bench_plots.h"

namespace culld::report {

/// A drawing with its heading above and a line of explanation below.
std::string figure(const std::string& title, const std::string& drawing, const std::string& note);

/// A small square of a colour, with its name.
std::string swatch(const char* color, const std::string& name);

/// Markers and names of the methods that appear in any of `scenes`.
std::string legend(const std::vector<SceneRows>& scenes);

std::string base64(const std::string& bytes);

/// Heading, facts, plots, picture and table of one scene.
std::string sceneSection(const SceneRows& rows, const std::string& legend);

}  // namespace culld::report
