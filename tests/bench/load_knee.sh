#!/bin/bash
# Finds how many clients a daemon of this machine bears: `cullctl load` on the demo's city with more and more of them, until more than one camera in a hundred is late or passed over.
# usage: load_knee.sh BIN_DIR [RATE_HZ [SECONDS [METHOD]]]   env CLIENTS="8 16 ..." chooses the steps, LOAD="--radius 0.5 --angle 0.1" adds options
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
source "$(dirname "${BASH_SOURCE[0]}")/../integration/cullctl_server.sh" "$1"
rate=${2:-60} seconds=${3:-10} method=${4:-auto}
read -ra more <<<"${LOAD:-}"
"$bin/make_scene" city --objects 120000 --frames 3600 -o "$work/city.glb" --cameras "$work/city.json" >/dev/null
start_server --scene "city=$work/city.glb"
echo "city of 120000 objects, method $method, $rate Hz, $seconds s a step${LOAD:+, $LOAD}; $(nproc) cores, load $(cut -d' ' -f1 /proc/loadavg)"
printf '%8s %10s %10s %12s %8s %8s %9s %9s %9s %9s\n' clients sent/s answered/s superseded% late% wrong 'p50 ms' 'p99 ms' 'p99.9 ms' 'cull ms'
knee=0
for clients in ${CLIENTS:-8 16 32 64 96 128 192 256}; do
  "$bin/cullctl" --connect "$unix" load city --cameras "$work/city.json" --method "$method" --clients "$clients" --rate "$rate" --seconds "$seconds" --json "${more[@]}" >"$work/load.json" ||
    die "load with $clients clients: $(cat "$work/load.json")"
  if python3 - "$work/load.json" <<'END'; then knee=$clients; else break; fi
import json, sys
r = json.load(open(sys.argv[1]))
l, sent = r["latency_ms"], max(r["sent"], 1)
over, late = 100 * r["superseded"] / sent, 100 * r["late"] / sent
print(f'{r["clients"]:8} {r["sent"] / r["seconds"]:10.0f} {r["answered"] / r["seconds"]:10.0f} {over:12.2f} {late:8.2f} {r["wrong"]:8} '
      f'{l["p50"]:9.3f} {l["p99"]:9.3f} {l["p999"]:9.3f} {r["cull_ms_mean"]:9.3f}')
sys.exit(over + late > 1)
END
done
echo "knee: $knee clients at $rate Hz"
