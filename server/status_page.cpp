#include "server/status_page.h"

namespace culld::server {

std::string_view statusPage() noexcept {
  return R"HTML(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>culld</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 60em; padding: 0 1em; color: #222; }
h1 { font-size: 1.5em; } h2 { font-size: 1.1em; margin-top: 2em; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: right; padding: .25em .6em; border-bottom: 1px solid #ddd; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; }
#state { color: #666; }
</style>
</head>
<body>
<h1>culld <span id="version"></span></h1>
<p id="state">connecting&hellip;</p>
<h2>Rates</h2>
<table id="rates"><tbody></tbody></table>
<h2>Scenes</h2>
<table id="scenes"><thead><tr><th>name</th><th>objects</th><th>triangles</th><th>version</th>
<th>method</th><th>sessions</th><th>views</th></tr></thead><tbody></tbody></table>
<script>
'use strict';
let last = null;
const text = (id, value) => { document.getElementById(id).textContent = value; };
function rows(id, list) {
  const body = document.querySelector('#' + id + ' tbody');
  body.replaceChildren(...list.map(cells => {
    const row = document.createElement('tr');
    for (const cell of cells) {
      const td = document.createElement('td');
      td.textContent = typeof cell === 'number' ? cell.toLocaleString('en') : cell;
      row.append(td);
    }
    return row;
  }));
}
function show(now) {
  text('version', now.version);
  text('state', (now.ready ? 'ready' : now.draining ? 'draining' : 'loading') + ', up ' +
       Math.round(now.uptime_s) + ' s');
  const t = now.totals, seconds = last ? now.uptime_s - last.uptime_s : 0;
  const rate = key => seconds > 0 ? (t[key] - last.totals[key]) / seconds : 0;
  const answers = rate('answers');
  rows('rates', [
    ['connections', t.connections], ['sessions', t.sessions], ['views', t.views],
    ['answers per second', Math.round(answers)],
    ['cameras superseded per second', Math.round(rate('superseded'))],
    ['bytes per answer', answers > 0 ? Math.round(rate('answer_bytes') / answers) : '–'],
    ['cull time per answer', answers > 0 ? (rate('cull_seconds') / answers * 1e3).toFixed(3) + ' ms' : '–'],
    ['answers in all', t.answers], ['errors in all', t.errors], ['edits in all', t.edits]]);
  rows('scenes', now.scenes.map(s =>
    [s.name, s.objects, s.triangles, s.version, s.method, s.sessions, s.views]));
  last = now;
}
async function poll() {
  try {
    show(await (await fetch('/v1/status')).json());
  } catch (failure) {
    text('state', 'no answer: ' + failure.message);
    last = null;
  }
  setTimeout(poll, 1000);
}
poll();
</script>
</body>
</html>
)HTML";
}

}  // namespace culld::server
