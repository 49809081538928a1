#include <algorithm>
#include <array>

#include "culling/report/bench_page.h"
#include "culling/report/svg.h"

namespace culld::report {
namespace {

double meanVisible(const std::vector<TruthFigures>& truths, std::size_t TruthFigures::*field) {
  std::vector<double> values;
  values.reserve(truths.size());
  for (const TruthFigures& truth : truths) values.push_back(static_cast<double>(truth.*field));
  return meanOf(values);
}

std::string introduction(const SceneRows& rows) {
  const SceneFigures& scene = rows.scene;
  const auto& truths = scene.truths.front();
  std::vector<double> unfound;
  for (const TruthFigures& truth : truths) unfound.push_back(truth.unfound);
  std::string html =
      "<p>" + shortNumber(static_cast<double>(scene.objects)) + " objects, " +
      shortNumber(static_cast<double>(scene.triangles)) + " triangles, " +
      shortBytes(static_cast<double>(scene.scene_bytes)) + " in memory; " +
      shortNumber(static_cast<double>(truths.size())) + " cameras, " +
      std::to_string(scene.repeat) + " repetitions. Per camera " +
      shortNumber(meanVisible(truths, &TruthFigures::in_frustum)) +
      " objects are in the frustum, " + shortNumber(meanVisible(truths, &TruthFigures::visible)) +
      " of them visible (" + shortNumber(meanVisible(truths, &TruthFigures::subpixel)) +
      " only through gaps below a pixel). One more round of rays would find about " +
      shortNumber(meanOf(unfound)) + " more.</p>\n";
  for (const RefusedMethod& refused : scene.refused) {
    html += "<p class=\"quiet\">" + escaped(refused.name) +
            " did not run: " + escaped(refused.why) + "</p>\n";
  }
  return html;
}

class Cells {
 public:
  explicit Cells(bool bad) : html_(bad ? "<tr class=\"bad\">" : "<tr>") {}
  Cells& left(const std::string& text) {
    html_ += "<td class=\"l\">" + escaped(text) + "</td>";
    return *this;
  }
  Cells& text(const std::string& words) {
    html_ += "<td>" + escaped(words) + "</td>";
    return *this;
  }
  Cells& number(double value) { return text(shortNumber(value)); }
  Cells& number(const std::optional<double>& value) {
    return text(value ? shortNumber(*value) : "-");
  }
  std::string row() const { return html_ + "</tr>\n"; }

 private:
  std::string html_;
};

constexpr std::array<const char*, 23> kHeads{
    "<th class=\"l\">method</th>",
    "<th class=\"l\">setting</th>",
    "<th class=\"l\">guarantee</th>",
    "<th>broken<small>answers</small></th>",
    "<th>missed<small>pixels + below</small></th>",
    "<th>missed<small>px</small></th>",
    "<th>lossy answers<small>px said / px lost / exceeded</small></th>",
    "<th>answered<small>per camera</small></th>",
    "<th>excess</th>",
    "<th>culled<small>of what could be</small></th>",
    "<th>time<small>least &ndash; median &ndash; 95 %</small></th>",
    "<th>cameras<small>min / median / p95 / max</small></th>",
    "<th>&times; frustum<small>median times</small></th>",
    "<th>&times; frustum<small>least times</small></th>",
    "<th>&times; frustum<small>counted work</small></th>",
    "<th>cut short<small>of answers</small></th>",
    "<th>nodes<small>visited</small></th>",
    "<th>objects<small>tested</small></th>",
    "<th>planes<small>tested</small></th>",
    "<th>depths<small>compared</small></th>",
    "<th>occluders<small>drawn</small></th>",
    "<th>triangles<small>drawn</small></th>",
    "<th>answer<small>whole / as a change</small></th>"};

/// Is what approximate answers say true? "1200 / 310 / 1 of 24"
std::string lossText(const RunSummary& sum) {
  if (sum.lossy == 0) return "&ndash;";
  return shortNumber(sum.said_px) + " / " + shortNumber(sum.lossy_missed_px) + " / " +
         std::to_string(sum.exceeded) + " of " + std::to_string(sum.lossy);
}

std::string rowOf(const SceneRows& rows, std::size_t i) {
  const BenchRun& run = rows.scene.runs[i];
  const RunSummary& sum = rows.rows[i];
  const MethodFigures& method = rows.scene.methods[run.method];
  Cells cells(run.breaches > 0);
  cells.left(sum.made_by.empty() ? method.name : method.name + " (" + sum.made_by + ")")
      .left(rows.scene.settings[run.setting].name());
  cells.left(std::string(guaranteeName(method.guarantee)));
  cells.number(static_cast<double>(run.breaches));
  cells.text(std::to_string(sum.missed) + " + " + std::to_string(sum.missed_subpixel));
  cells.number(sum.missed_px).text(lossText(sum));
  cells.number(sum.answered).number(sum.excess);
  cells.text(percent(sum.culled_share));
  cells.text(shortTime(sum.low_us) + " \u2013 " + shortTime(sum.mean_us) + " \u2013 " +
             shortTime(sum.high_us));
  cells.text(shortTime(sum.cameras_us.min) + " / " + shortTime(sum.cameras_us.median) + " / " +
             shortTime(sum.cameras_us.p95) + " / " + shortTime(sum.cameras_us.max));
  cells.number(sum.relative).number(sum.relative_min).number(sum.relative_work);
  cells.text(percent(sum.out_of_budget));
  cells.number(sum.nodes_visited)
      .number(sum.tested)
      .number(sum.plane_tests)
      .number(sum.depth_comparisons);
  cells.number(sum.occluders_drawn).number(sum.triangles_drawn);
  cells.text(shortBytes(sum.answer_bytes) + " / " + shortBytes(sum.change_bytes));
  return cells.row();
}

std::string table(const SceneRows& rows) {
  std::string html = "<div class=\"table\"><table><thead><tr>";
  for (const char* head : kHeads) html += head;
  html += "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < rows.rows.size(); ++i) html += rowOf(rows, i);
  return html + "</tbody></table></div>\n";
}

std::string picture(const SceneFigures& scene) {
  if (scene.picture_png.empty()) return "";
  return "<figure class=\"picture\"><figcaption>The worst frame: " + escaped(scene.picture_title) +
         "</figcaption><img alt=\"" + escaped(scene.picture_title) +
         "\" src=\"data:image/png;base64," + base64(scene.picture_png) +
         "\"><p class=\"quiet\">Where most is missed; nothing missed anywhere: where most is "
         "answered in vain by the method that answers least. Outlines are boxes of hidden objects, "
         "drawn through what hides them.</p></figure>\n";
}

std::string plots(const SceneRows& rows) {
  const RunSummary& base = rows.rows[rows.unlimited(rows.scene.baseline)];
  std::string html = "<div class=\"plots\">";
  html += figure("Missed objects against time", missedPlot(rows), "0 has a place of its own.");
  html += figure("Missed pixels against time", missedPxPlot(rows),
                 "The pixels that the missed objects would have covered.");
  html += figure("Excess against time", excessPlot(rows), "Down and left is better.");
  html += figure("Time over the camera path", pathPlot(rows),
                 "First image size, no time limit. Many cameras are drawn in groups.");
  html +=
      "<figure><figcaption>What each stage brought</figcaption><div class=\"legend\">" +
      swatch(kVisibleColor, "visible") + swatch(kKeptColor, "hidden, answered anyway") +
      swatch(kLeftOutColor, "left out by occlusion") + "</div>" + stagesPlot(rows) +
      "<p class=\"quiet\">Objects per camera that the frustum alone does not leave out (it "
      "leaves out " +
      shortNumber(base.outside) + " of " + shortNumber(static_cast<double>(rows.scene.objects)) +
      "). At the right what occlusion left out further, and the time it took more.</p></figure>";
  html += "<figure><figcaption>Memory</figcaption><div class=\"legend\">" +
          swatch(kPreparedColor, "prepared, shared by all views") +
          swatch(kViewColor, "kept by each view") + "</div>" + memoryPlot(rows) +
          "<p class=\"quiet\">Beside the scene itself.</p><div class=\"caption\">Preparing the "
          "scene, once</div>" +
          preparePlot(rows) + "<p class=\"quiet\">One measurement each.</p></figure>";
  return html + "</div>\n";
}

}  // namespace

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) -> std::uint32_t {
      return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U;
    };
    const std::uint32_t three = byte(0) << 16U | byte(1) << 8U | byte(2);
    text += kDigits[three >> 18U];
    text += kDigits[three >> 12U & 63U];
    text += i + 1 < bytes.size() ? kDigits[three >> 6U & 63U] : '=';
    text += i + 2 < bytes.size() ? kDigits[three & 63U] : '=';
  }
  return text;
}

std::string sceneSection(const SceneRows& rows, const std::string& legend) {
  return introduction(rows) + legend + plots(rows) + picture(rows.scene) + table(rows);
}

}  // namespace culld::report
