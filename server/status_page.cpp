#include "server/status_page.h"

namespace culld::server {

// Everything shown comes from /v1/status; rates are differences of two replies.
std::string_view statusPage() noexcept {
  return R"HTML(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>culld</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 72em; padding: 0 1em; color: #222; }
h1 { font-size: 1.5em; } h2 { font-size: 1.1em; margin-top: 2em; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: right; padding: .25em .6em; border-bottom: 1px solid #ddd; vertical-align: top; white-space: nowrap; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child, th.words, td.words { text-align: left; white-space: normal; }
#state, .note { color: #666; }
</style>
</head>
<body>
<h1 id="version">culld</h1>
<p id="state">connecting&hellip;</p>
<form id="login" hidden><label>This server asks for a token: <input type="password" id="token" autocomplete="off"></label> <button>Use it</button></form>
<h2>Rates</h2>
<table id="rates"><tbody></tbody></table>
<h2>Scenes</h2>
<table id="scenes"><thead><tr><th>name</th><th>objects</th><th>triangles</th><th>version</th>
<th>sessions</th><th>views</th><th>answers per second</th><th>cull time</th><th>objects per answer</th>
<th class="words">methods in use</th></tr></thead><tbody></tbody></table>
<h2>Plans</h2>
<table id="plans"><thead><tr><th>name</th><th class="words">stages</th><th class="words">occlusion</th><th class="words">why</th></tr></thead><tbody></tbody></table>
<p class="note">What <code>auto</code> does for a scene, decided when the first view asks. A dash: nobody has asked yet.</p>
<script>
'use strict';
let last = null;
const none = '–';
const text = (id, value) => { document.getElementById(id).textContent = value; };
function rows(id, list) {
  const words = [...document.querySelectorAll('#' + id + ' th')].map(th => th.className);
  const body = document.querySelector('#' + id + ' tbody');
  body.replaceChildren(...list.map(cells => {
    const row = document.createElement('tr');
    cells.forEach((cell, column) => {
      const td = document.createElement('td');
      td.textContent = typeof cell === 'number' ? cell.toLocaleString('en') : cell;
      td.className = words[column] || '';
      row.append(td);
    });
    return row;
  }));
}
const milliseconds = (seconds, answers) => answers > 0 ? (seconds / answers * 1e3).toFixed(3) + ' ms' : none;
const each = (sum, answers) => answers > 0 ? Math.round(sum / answers) : none;
function showRates(now, seconds) {
  const t = now.totals;
  if (!t) return rows('rates', [['the operator\'s only', '']]);
  const gained = key => last && last.totals ? t[key] - last.totals[key] : 0;
  const rate = key => seconds > 0 ? Math.round(gained(key) / seconds) : 0;
  rows('rates', [
    ['connections', t.connections], ['sessions', t.sessions], ['views', t.views],
    ['answers per second', rate('answers')], ['cameras superseded per second', rate('superseded')],
    ['bytes per second', rate('answer_bytes')], ['bytes per answer', each(gained('answer_bytes'), gained('answers'))],
    ['cull time per answer', milliseconds(gained('cull_seconds'), gained('answers'))],
    ['answers in all', t.answers], ['errors in all', t.errors], ['edits in all', t.edits]]);
}
// What each method did for a scene since the last reply; with nothing new, nothing.
function gains(scene) {
  const before = last && last.scenes.find(s => s.name === scene.name);
  return (scene.uses || []).map(use => {
    const then = before && (before.uses || []).find(u => u.method === use.method);
    const gain = key => use[key] - (then ? then[key] : before ? 0 : use[key]);
    return {method: use.method, answers: gain('answers'), objects: gain('objects'), cull_seconds: gain('cull_seconds')};
  }).filter(gain => gain.answers > 0);
}
function sceneRow(s, seconds) {
  const used = gains(s), sum = key => used.reduce((all, gain) => all + gain[key], 0), answers = sum('answers');
  const shares = used.sort((a, b) => b.answers - a.answers)
    .map(gain => gain.method + ' ' + Math.round(100 * gain.answers / answers) + ' %');
  return [s.name, s.objects, s.triangles, s.version, s.sessions ?? none, s.views ?? none,
    seconds > 0 ? Math.round(answers / seconds) : 0, milliseconds(sum('cull_seconds'), answers),
    each(sum('objects'), answers), shares.join(', ') || none];
}
function show(now) {
  const seconds = last ? now.uptime_s - last.uptime_s : 0;
  if (seconds < 0) last = null;  // it was started anew
  text('version', now.version);
  text('state', (now.draining ? 'draining' : now.ready ? 'ready' : 'loading') + ', up ' + Math.round(now.uptime_s) + ' s');
  showRates(now, seconds);
  rows('scenes', now.scenes.map(s => sceneRow(s, seconds)));
  rows('plans', now.scenes.map(s => s.plan
    ? [s.name, s.plan.stages.join(', then '), s.plan.occlusion, s.plan.why] : [s.name, none, none, none]));
  last = now;
}
async function poll() {
  const token = sessionStorage.getItem('token');
  try {
    const reply = await fetch('/v1/status', token ? {headers: {Authorization: 'Bearer ' + token}} : {});
    const status = await reply.json();
    document.getElementById('login').hidden = reply.status !== 401;
    if (!reply.ok) throw new Error(status.error);
    show(status);
  } catch (failure) {
    text('state', 'no answer: ' + failure.message);
    last = null;
  }
  setTimeout(poll, 1000);
}
document.getElementById('login').onsubmit = event => {
  event.preventDefault();
  sessionStorage.setItem('token', document.getElementById('token').value);
};
poll();
</script>
</body>
</html>
)HTML";
}

}  // namespace culld::server
