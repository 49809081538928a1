#include <algorithm>
#include <map>

#include "culling/report/bench_page.h"
#include "culling/report/svg.h"

namespace culld::report {
namespace {

constexpr const char* kStyleSheet = R"(
:root{color-scheme:light}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1500px;padding:20px 24px 60px;color:#1b1f24;background:#fff;
 font:15px/1.5 system-ui,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
h1{font-size:26px;margin:14px 0 6px}
h2{font-size:21px;margin:44px 0 4px;padding-top:14px;border-top:2px solid #d5dae0;overflow-wrap:anywhere}
p{margin:6px 0;max-width:78em}
.verdict{font-size:16px;font-weight:600;padding:12px 16px;border-radius:6px;overflow-wrap:anywhere}
.held{background:#e3f4ec;border-left:6px solid #009e73}
.broken{background:#fdeae0;border-left:6px solid #d55e00}
.quiet{color:#57606a;font-size:13.5px}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,390px),1fr));gap:18px 26px;margin:14px 0}
figure{margin:0;min-width:0;break-inside:avoid}
figcaption,.caption{font-weight:600;font-size:14.5px;margin-bottom:2px}
figure .quiet{margin:0;font-size:12.5px}
figure svg{width:100%;height:auto;display:block}
figure.picture{max-width:960px;margin:14px 0}
figure.picture img{width:100%;height:auto;display:block;border-radius:4px}
svg text{font-family:inherit;fill:#1b1f24;font-size:11.5px}
svg .tick{font-size:11px;fill:#444c56}
svg .name{font-size:12px;fill:#1b1f24}
svg .row{font-size:12px;font-weight:600}
svg .value{font-size:12px}
svg .point{font-size:10px;fill:#444c56}
svg .point,svg .row,svg .words{paint-order:stroke;stroke:#fff;stroke-width:3px;stroke-linejoin:round}
svg .words{font-size:13px;fill:#57606a}
td small{color:#57606a}
svg .mid{text-anchor:middle}
svg .end{text-anchor:end}
svg .strong{font-weight:700;fill:#1b1f24}
svg .grid{stroke:#e4e8ec;stroke-width:1}
svg .rail{stroke:#cfd6dd;stroke-width:1}
svg .zero{stroke:#009e73;stroke-width:1.4}
svg .axis{stroke:#57606a;stroke-width:1.2}
svg .compare{stroke:#57606a;stroke-width:1.2;stroke-dasharray:5 4}
svg .front{fill:none;stroke:#8b949e;stroke-width:1.6;stroke-dasharray:1 4;stroke-linecap:round}
svg .halo{fill:#c9d1d9;opacity:.75}
.legend{display:flex;flex-wrap:wrap;gap:4px 20px;margin:10px 0 0;font-size:14px;align-items:center}
.legend span{display:inline-flex;align-items:center;gap:6px}
.legend svg{width:44px;height:22px}
.swatch{display:inline-block;width:13px;height:13px;border-radius:2px;vertical-align:-2px;margin-right:5px}
.table{overflow-x:auto;margin:12px 0}
table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums;white-space:nowrap}
th,td{padding:4px 10px;text-align:right;border-bottom:1px solid #e4e8ec}
th{font-weight:600;vertical-align:bottom;border-bottom:2px solid #8b949e;background:#fff}
th.l,td.l{text-align:left}
th small{display:block;font-weight:400;color:#57606a}
tr.bad td{background:#fdeae0;font-weight:600}
tr.first td{border-top:1.5px solid #8b949e}
dl{display:grid;grid-template-columns:max-content 1fr;gap:2px 18px;font-size:13.5px;margin:10px 0}
dt{color:#57606a}dd{margin:0;overflow-wrap:anywhere}
nav{font-size:14px;line-height:1.9}nav a{margin-right:14px;white-space:nowrap}
a{color:#0a58a8}
@media(max-width:600px){body{padding:12px 12px 40px}h1{font-size:21px}h2{font-size:18px}}
@page{size:A4 landscape;margin:10mm}
@media print{body{max-width:none;padding:0;font-size:11px}h2{break-before:page;margin-top:0}
 h2:first-of-type{break-before:auto}nav{display:none}figure.picture{max-width:150mm}
 .plots{grid-template-columns:1fr 1fr 1fr}table{font-size:7px}th,td{padding:2px 3px}.table{overflow:visible}
 *{-webkit-print-color-adjust:exact;print-color-adjust:exact}}
)";

std::string summaryRow(const SceneRows& rows, std::size_t method, bool first) {
  const std::size_t i = rows.unlimited(method);
  const RunSummary& sum = rows.rows[i];
  const auto cell = [](const std::string& text) { return "<td>" + text + "</td>"; };
  const auto number = [&](const std::optional<double>& v) {
    return cell(v ? shortNumber(*v) : "-");
  };
  std::string row = std::string("<tr class=\"") + (rows.scene.runs[i].breaches > 0 ? "bad " : "") +
                    (first ? "first" : "") + "\"><td class=\"l\">";
  if (first) row += escaped(rows.scene.name);
  row += "</td><td class=\"l\">" + escaped(rows.scene.methods[method].name) +
         (sum.made_by.empty() ? "" : " <small>" + escaped(sum.made_by) + "</small>") + "</td>";
  row += cell(std::to_string(sum.missed) + " + " + std::to_string(sum.missed_subpixel));
  row += cell(shortNumber(sum.visible)) + cell(shortNumber(sum.answered)) + number(sum.excess);
  row += cell(percent(sum.culled_share)) + cell(shortTime(sum.mean_us));
  row += number(sum.relative) + number(sum.relative_min) + number(sum.relative_work);
  row += cell(shortTime(1e3 * rows.scene.methods[method].prepare_ms));
  row += cell(shortBytes(static_cast<double>(rows.scene.methods[method].prepared_bytes)));
  return row + cell(shortBytes(sum.answer_bytes)) + "</tr>\n";
}

std::string summaryTable(const std::vector<SceneRows>& scenes) {
  std::string html =
      "<div class=\"table\"><table><thead><tr><th class=\"l\">scene</th><th class=\"l\">method</th>"
      "<th>missed<small>pixels + below</small></th><th>visible<small>per camera</small></th>"
      "<th>answered<small>per camera</small></th><th>excess</th>"
      "<th>culled<small>of what could be</small></th><th>time<small>per camera</small></th>"
      "<th>&times; frustum<small>median times</small></th>"
      "<th>&times; frustum<small>least times</small></th>"
      "<th>&times; frustum<small>counted work</small></th>"
      "<th>prepare<small>once</small></th><th>prepared</th>"
      "<th>answer<small>on the wire, whole</small></th></tr></thead><tbody>\n";
  for (const SceneRows& scene : scenes) {
    for (std::size_t m = 0; m < scene.scene.methods.size(); ++m) {
      html += summaryRow(scene, m, m == 0);
    }
  }
  return html + "</tbody></table></div>\n";
}

std::string factList(const BenchFacts& facts) {
  std::string html = "<dl>";
  for (const auto& [name, value] : facts) {
    html += "<dt>" + escaped(name) + "</dt><dd>" + escaped(value) + "</dd>";
  }
  return html + "</dl>\n";
}

std::string verdictBlock(const BenchReport& report) {
  const std::vector<Breach> breaches = report.breaches();
  std::string html = std::string("<p class=\"verdict ") + (breaches.empty() ? "held" : "broken") +
                     "\">" + escaped(report.verdict()) + "</p>\n";
  if (breaches.size() < 2) return html;
  html += "<ul>";
  for (const Breach& breach : breaches) html += "<li>" + escaped(breach.line()) + "</li>";
  return html + "</ul>\n";
}

std::string overviewSection(const std::vector<SceneRows>& scenes, const std::string& legend) {
  std::string html = "<h2>All scenes</h2>\n";
  html +=
      "<p class=\"quiet\">At the first image size and without time limit; settings are "
      "compared scene by scene below.</p>" +
      legend + "<div class=\"plots\">";
  html += figure("Excess", excessOverview(scenes),
                 "1 is perfect: nothing answered but what is visible. Left is better.");
  html += figure("Cost beside frustum culling", costOverview(scenes),
                 "Ratio of interleaved runs. Left is better.");
  html += figure("Time", timeOverview(scenes), "Mean over the cameras. Left is better.");
  return html + "</div>\n" + summaryTable(scenes);
}

}  // namespace

std::string figure(const std::string& title, const std::string& drawing, const std::string& note) {
  return "<figure><figcaption>" + escaped(title) + "</figcaption>" + drawing +
         "<p class=\"quiet\">" + escaped(note) + "</p></figure>\n";
}

std::string swatch(const char* color, const std::string& name) {
  return std::string("<span><i class=\"swatch\" style=\"background:") + color + "\"></i>" +
         escaped(name) + "</span>";
}

std::string legend(const std::vector<SceneRows>& scenes) {
  std::map<std::size_t, std::string> names;  // by style
  for (const SceneRows& rows : scenes) {
    for (std::size_t m = 0; m < rows.scene.methods.size(); ++m) {
      names.emplace(styleIndex(rows.scene, m), rows.scene.methods[m].name);
    }
  }
  std::string html = "<div class=\"legend\">";
  for (const auto& [style, name] : names) {
    const Style look = styleOf(style);
    html += std::string(
                "<span><svg viewBox=\"0 0 44 22\"><line x1=\"1\" y1=\"11\" x2=\"43\" "
                "y2=\"11\" stroke=\"") +
            look.color + "\" stroke-width=\"1.8\" stroke-dasharray=\"" + look.dash + "\"/>" +
            marker(style, 22, 11, 5) + "</svg>" + escaped(name) + "</span>";
  }
  return html +
         "<span><svg viewBox=\"0 0 44 22\"><line class=\"front\" x1=\"1\" y1=\"11\" x2=\"43\" "
         "y2=\"11\"/><circle class=\"halo\" cx=\"22\" cy=\"11\" r=\"9\"/></svg>"
         "on the Pareto front of time and excess</span></div>";
}

}  // namespace culld::report

namespace culld {

std::string benchHtml(const BenchReport& report) {
  using namespace report;  // the pieces
  std::vector<SceneRows> scenes;
  for (const SceneFigures& scene : report.scenes) scenes.emplace_back(scene);
  const std::string key = legend(scenes);
  std::string html = "<!-- " + escaped(report.verdict()) + " -->\n<!DOCTYPE html>\n";
  html +=
      "<html lang=\"en\"><head><meta charset=\"utf-8\"><title>culld bench</title>"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><style>" +
      std::string(kStyleSheet) + "</style></head><body>\n";
  html += verdictBlock(report) + "<h1>culld bench: error against run time</h1>\n";
  html +=
      "<p>Every answer was held against ray-cast truth. <b>Missed</b> objects are visible and "
      "were not answered; <b>excess</b> is objects answered per object visible. Times are wall "
      "clock per camera: points are medians over interleaved repetitions, bars and bands go "
      "from the least to the 95 % point and show the noise of the machine.</p>\n";
  if (scenes.size() > 1) {
    html += "<nav>";
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      html +=
          "<a href=\"#scene" + std::to_string(i) + "\">" + escaped(scenes[i].scene.name) + "</a> ";
    }
    html += "</nav>\n" + overviewSection(scenes, key);
  }
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    html +=
        "<h2 id=\"scene" + std::to_string(i) + "\">" + escaped(scenes[i].scene.name) + "</h2>\n";
    html += sceneSection(scenes[i], key);
  }
  return html + "<h2>How this was measured</h2>\n" + factList(report.facts) + "</body></html>\n";
}

}  // namespace culld
