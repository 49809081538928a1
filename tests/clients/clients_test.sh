#!/bin/bash
# Clients that share no code with culld hold a conversation with it. usage: clients_test.sh BIN_DIR FLATC SCHEMA LWS_CLIENT
# shellcheck source=tests/integration/cullctl_server.sh disable=SC2154
here=$(dirname "${BASH_SOURCE[0]}")
source "$here/../integration/cullctl_server.sh" "$1"
flatc=$2 schema=$3 lws_client=$4

"$flatc" --python --gen-object-api -o "$work/generated" "$schema" || die "flatc"
"$bin/make_scene" city --objects 3000 --frames 40 -o "$work/city.glb" --cameras "$work/city.json" >/dev/null
"$bin/culld" cull "$work/city.glb" --cameras "$work/city.json" --method frustum -o "$work/truth.json" >/dev/null
start_server --scene city="$work/city.glb"
# Debian's Python has Debian's websockets and flatbuffers; another one in PATH has not.
timeout 250 /usr/bin/python3 "$here/python_client.py" "$port" city "$work/city.json" "$work/truth.json" "$work/generated" || die "python_client.py"

"$lws_client" "$port" city >"$work/lws.log" &
client=$!
for _ in $(seq 600); do
  ! grep -q waits "$work/lws.log" || break
  kill -0 "$client" 2>/dev/null || die "lws_client ended"
  sleep 0.1
done
stop_server
wait "$client" || die "lws_client"
grep -q fine "$work/lws.log" || die "lws_client did not end well"
