#include "server/config_keys.h"

#include <sys/un.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <charconv>
#include <chrono>
#include <cmath>

#include "culling/gpu/backend.h"

namespace culld::server {
namespace {

constexpr bool kReloaded = true;
constexpr bool kAtStart = false;
constexpr std::int64_t kMany = 1'000'000;

/// `access(config)` is the place of an unsigned number.
template <typename Access>
ConfigKey whole(std::string name, bool reloaded, std::int64_t least, std::int64_t most,
                Access access, std::string what) {
  ConfigKey key;
  key.name = std::move(name);
  key.kind = KeyKind::kWhole;
  key.reloaded = reloaded;
  key.range = std::to_string(least) + " to " + std::to_string(most);
  key.what = std::move(what);
  key.set = [access, least, most, range = key.range](Config& config,
                                                     const ConfigValue& value) -> Result<void> {
    const auto number = std::get<std::int64_t>(value);
    if (number < least || number > most) return invalidInput("is not from " + range);
    auto& place = access(config);
    place = static_cast<std::remove_reference_t<decltype(place)>>(number);
    return Done{};
  };
  key.get = [access](const Config& config) -> ConfigValue {
    return static_cast<std::int64_t>(access(config));
  };
  return key;
}

/// Seconds in the file, milliseconds inside.
template <typename Access>
ConfigKey seconds(std::string name, Access access, std::string what) {
  ConfigKey key;
  key.name = std::move(name);
  key.kind = KeyKind::kNumber;
  key.reloaded = kReloaded;
  key.range = "0.001 to 86400";
  key.what = std::move(what);
  key.set = [access](Config& config, const ConfigValue& value) -> Result<void> {
    const double number = std::get<double>(value);
    if (!(number >= 0.001 && number <= 86'400)) return invalidInput("is not from 0.001 to 86400");
    access(config) = std::chrono::milliseconds(std::llround(number * 1000));
    return Done{};
  };
  key.get = [access](const Config& config) -> ConfigValue {
    return static_cast<double>(access(config).count()) / 1000;
  };
  return key;
}

using Check = Result<void> (*)(const std::string&);

Result<void> anyText(const std::string&) { return Done{}; }

template <typename Access>
ConfigKey text(std::string name, KeyKind kind, bool reloaded, Access access, std::string what,
               Check check = anyText) {
  ConfigKey key;
  key.name = std::move(name);
  key.kind = kind;
  key.reloaded = reloaded;
  key.what = std::move(what);
  key.set = [access, check](Config& config, const ConfigValue& value) -> Result<void> {
    const auto& given = std::get<std::string>(value);
    if (given.empty()) return invalidInput("is empty");
    if (given.find('\0') != std::string::npos) return invalidInput("holds a null character");
    if (auto checked = check(given); !checked) return checked;
    access(config) = given;
    return Done{};
  };
  key.get = [access](const Config& config) -> ConfigValue { return access(config); };
  return key;
}

/// One of a few words, each of which stands for a value.
template <typename Access, typename Value>
ConfigKey choice(std::string name, bool reloaded,
                 std::vector<std::pair<std::string, Value>> choices, Access access,
                 std::string what) {
  ConfigKey key;
  key.name = std::move(name);
  key.reloaded = reloaded;
  for (const auto& [word, value] : choices) key.range += (key.range.empty() ? "" : ", ") + word;
  key.what = std::move(what);
  key.set = [access, choices, range = key.range](Config& config,
                                                 const ConfigValue& given) -> Result<void> {
    for (const auto& [word, value] : choices) {
      if (word != std::get<std::string>(given)) continue;
      access(config) = value;
      return Done{};
    }
    return invalidInput("is none of " + range);
  };
  key.get = [access, choices](const Config& config) -> ConfigValue {
    for (const auto& [word, value] : choices) {
      if (value == access(config)) return word;
    }
    return std::string();
  };
  return key;
}

template <typename Access>
ConfigKey list(std::string name, Access access, std::string what) {
  ConfigKey key;
  key.name = std::move(name);
  key.kind = KeyKind::kList;
  key.reloaded = kReloaded;
  key.what = std::move(what);
  key.set = [access](Config& config, const ConfigValue& value) -> Result<void> {
    for (const std::string& entry : std::get<std::vector<std::string>>(value)) {
      if (entry.empty()) return invalidInput("holds an empty text");
    }
    access(config) = std::get<std::vector<std::string>>(value);
    return Done{};
  };
  key.get = [access](const Config& config) -> ConfigValue { return access(config); };
  return key;
}

Result<void> checkListen(const std::string& text) {
  const auto address = parseListen(text);
  return address ? Result<void>(Done{}) : address.error();
}

Result<void> checkSocketPath(const std::string& path) {
  if (path.size() < sizeof(sockaddr_un::sun_path)) return Done{};
  return invalidInput("path too long for a socket");
}

Result<void> checkBackend(const std::string& name) {
  const auto choice = gpu::backendNamed(name);
  return choice ? Result<void>(Done{}) : choice.error();
}

using Words = std::vector<std::pair<std::string, std::string>>;

std::vector<ConfigKey> generalKeys() {
  const auto named = [](ConfigKey key) {
    key.flag = "--" + key.name;
    return key;
  };
  return {
      named(text(
          "listen", KeyKind::kText, kAtStart, [](auto& c) -> auto& { return c.listen; },
          "HOST:PORT; port 0 takes a free one", checkListen)),
      named(text(
          "unix", KeyKind::kPath, kAtStart, [](auto& c) -> auto& { return c.unix_path; },
          "Listen on this Unix socket too", checkSocketPath)),
      named(text(
          "data", KeyKind::kPath, kAtStart, [](auto& c) -> auto& { return c.data_folder; },
          "Keep uploaded scenes here across restarts")),
      named(whole(
          "threads", kAtStart, 0, 1024, [](auto& c) -> auto& { return c.threads; },
          "For culling; 0: as many as cores")),
      named(text(
          "backend", KeyKind::kText, kAtStart, [](auto& c) -> auto& { return c.backend; },
          "What draws for methods on a GPU: auto, cpu, egl-device[:n], egl-surfaceless, osmesa",
          checkBackend)),
      named(choice(
          "simd", kAtStart,
          Words{{"auto", "auto"}, {"sse4", "sse4"}, {"avx2", "avx2"}, {"avx3", "avx3"}},
          [](auto& c) -> auto& { return c.simd; }, "Force a SIMD target: sse4, avx2, avx3")),
  };
}

std::vector<ConfigKey> logKeys() {
  std::vector<ConfigKey> keys{
      choice(
          "log.format", kReloaded,
          std::vector<std::pair<std::string, LogFormat>>{{"text", LogFormat::kText},
                                                         {"json", LogFormat::kJson}},
          [](auto& c) -> auto& { return c.log.format; }, "text or json lines"),
      choice(
          "log.level", kReloaded,
          std::vector<std::pair<std::string, LogLevel>>{{"debug", LogLevel::kDebug},
                                                        {"info", LogLevel::kInfo},
                                                        {"warning", LogLevel::kWarning},
                                                        {"error", LogLevel::kError}},
          [](auto& c) -> auto& { return c.log.level; }, "debug, info, warning or error"),
  };
  keys[0].flag = "--log-format";
  keys[1].flag = "--log-level";
  return keys;
}

std::vector<ConfigKey> sessionLimitKeys() {
  return {
      whole(
          "limits.max_message_bytes", kReloaded, 1024, protocol::kMaxRequestBytes,
          [](auto& c) -> auto& { return c.limits.session.max_message_bytes; },
          "a message to the server"),
      whole(
          "limits.max_views", kReloaded, 1, protocol::kMaxViews,
          [](auto& c) -> auto& { return c.limits.session.max_views; }, "views of a session"),
      whole(
          "limits.max_edits_per_request", kReloaded, 1, protocol::kMaxEdits,
          [](auto& c) -> auto& { return c.limits.session.max_edits_per_request; },
          "items of an Edit"),
      whole(
          "limits.max_waiting_edits", kReloaded, 1, kMany,
          [](auto& c) -> auto& { return c.limits.session.max_waiting_edits; },
          "Edits of a session that wait"),
      whole(
          "limits.max_requests_in_flight", kReloaded, 1, kMany,
          [](auto& c) -> auto& { return c.limits.session.max_requests_in_flight; },
          "cameras and edits of a session under way"),
      whole(
          "limits.max_messages_per_s", kReloaded, 0, kMany,
          [](auto& c) -> auto& { return c.limits.session.max_messages_per_s; },
          "past it a session is read from later; 0: any"),
      whole(
          "limits.kept_frames", kReloaded, 1, kMany,
          [](auto& c) -> auto& { return c.limits.session.kept_frames; },
          "answers of a view that later ones may build on"),
      whole(
          "limits.kept_ids", kReloaded, 0, std::int64_t{1} << 40,
          [](auto& c) -> auto& { return c.limits.session.kept_ids; }, "ids in all of those"),
      seconds(
          "limits.hello_timeout_s", [](auto& c) -> auto& { return c.limits.session.hello_timeout; },
          "time to Hello"),
      seconds(
          "limits.idle_timeout_s", [](auto& c) -> auto& { return c.limits.session.idle_timeout; },
          "silence of a session, pings unanswered"),
  };
}

std::vector<ConfigKey> connectionLimitKeys() {
  constexpr std::int64_t kBytes = std::int64_t{1} << 50;
  return {
      whole(
          "limits.max_connections", kReloaded, 1, kMany,
          [](auto& c) -> auto& { return c.limits.max_connections; }, "connections"),
      whole(
          "limits.max_connections_per_address", kReloaded, 0, kMany,
          [](auto& c) -> auto& { return c.limits.max_connections_per_address; },
          "the same from one IPv4 address or IPv6 network; 0: any"),
      whole(
          "limits.max_scenes", kAtStart, 1, kMany,
          [](auto& c) -> auto& { return c.limits.max_scenes; }, "scenes"),
      whole(
          "limits.max_upload_bytes", kReloaded, 1, kBytes,
          [](auto& c) -> auto& { return c.limits.max_upload_bytes; }, "an upload"),
      whole(
          "limits.max_header_bytes", kReloaded, 256, std::int64_t{1} << 20,
          [](auto& c) -> auto& { return c.limits.max_header_bytes; }, "a request's header"),
      whole(
          "limits.min_upload_bytes_per_s", kReloaded, 0, kBytes,
          [](auto& c) -> auto& { return c.limits.min_upload_bytes_per_s; },
          "slower uploads are ended"),
      seconds(
          "limits.header_timeout_s", [](auto& c) -> auto& { return c.limits.header_timeout; },
          "time for a header, and between requests"),
      seconds(
          "limits.body_timeout_s", [](auto& c) -> auto& { return c.limits.body_timeout; },
          "pause within an upload"),
      seconds(
          "limits.write_timeout_s", [](auto& c) -> auto& { return c.limits.write_timeout; },
          "time for the peer to take an HTTP reply or a live message"),
      seconds(
          "limits.drain_timeout_s", [](auto& c) -> auto& { return c.limits.drain_timeout; },
          "time to finish after SIGTERM"),
      whole(
          "limits.max_queued_bytes", kReloaded, 1, kBytes,
          [](auto& c) -> auto& { return c.limits.queued_bytes; },
          "waiting for a client; past it the server stops reading from it"),
      whole(
          "limits.max_queued_messages", kReloaded, 1, kMany,
          [](auto& c) -> auto& { return c.limits.queued_messages; }, "the same"),
      whole(
          "limits.max_total_queued_bytes", kReloaded, 1, kBytes,
          [](auto& c) -> auto& { return c.limits.total_queued_bytes; },
          "over all clients; past it those that have some waiting are not read from"),
  };
}

std::vector<ConfigKey> accessKeys() {
  ConfigKey allow_public;
  allow_public.name = "access.allow_public";
  allow_public.flag = "--allow-public";
  allow_public.kind = KeyKind::kSwitch;
  allow_public.reloaded = kReloaded;
  allow_public.what = "listen on a public address without tokens or TLS";
  allow_public.set = [](Config& config, const ConfigValue& value) -> Result<void> {
    config.access.allow_public = std::get<bool>(value);
    return Done{};
  };
  allow_public.get = [](const Config& c) -> ConfigValue { return c.access.allow_public; };
  return {
      text(
          "tls.certificate", KeyKind::kPath, kReloaded,
          [](auto& c) -> auto& { return c.tls.certificate_file; }, "PEM file of the TCP port"),
      text(
          "tls.key", KeyKind::kPath, kReloaded, [](auto& c) -> auto& { return c.tls.key_file; },
          "PEM file of its private key"),
      text(
          "access.tokens", KeyKind::kPath, kReloaded,
          [](auto& c) -> auto& { return c.access.tokens_file; }, "file of tokens and tenants"),
      list(
          "access.origins", [](auto& c) -> auto& { return c.access.origins; },
          "of browsers, besides the server's own"),
      list(
          "access.unix_users", [](auto& c) -> auto& { return c.access.unix_users; },
          "names or numbers that may use the Unix socket"),
      allow_public,
  };
}

}  // namespace

std::string ConfigKey::variable() const {
  std::string out = "CULLD_" + name;
  for (char& c : out) {
    if (c == '.') c = '_';
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return out;
}

const std::vector<ConfigKey>& configKeys() {
  static const std::vector<ConfigKey> kKeys = [] {
    std::vector<ConfigKey> all;
    for (auto& part :
         {generalKeys(), logKeys(), connectionLimitKeys(), sessionLimitKeys(), accessKeys()}) {
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }();
  return kKeys;
}

const ConfigKey* findKey(std::string_view name) {
  const auto& keys = configKeys();
  const auto at = std::find_if(keys.begin(), keys.end(),
                               [name](const ConfigKey& key) { return key.name == name; });
  return at == keys.end() ? nullptr : &*at;
}

Result<ListenAddress> parseListen(const std::string& text) {
  const auto wrong = invalidInput("not HOST:PORT");
  const auto colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return wrong;
  ListenAddress out;
  const char* end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data() + colon + 1, end, out.port);
  if (failure != std::errc() || stop != end) return wrong;
  out.host = text.substr(0, colon);
  if (out.host.size() > 2 && out.host.front() == '[' && out.host.back() == ']') {
    out.host = out.host.substr(1, out.host.size() - 2);
  }
  if (out.host == "localhost") out.host = "127.0.0.1";
  boost::system::error_code refused;
  boost::asio::ip::make_address(out.host, refused);
  if (refused) return invalidInput(out.host + " is not an IP address");
  return out;
}

}  // namespace culld::server
