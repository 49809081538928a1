#include "server/log.h"

#include <spdlog/logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "protocol/text.h"

namespace culld::server {
namespace {

using Fields = std::initializer_list<LogField>;
using nlohmann::json;

constexpr std::size_t kWatchedMessages = 256;

spdlog::level::level_enum levelOf(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      break;
  }
  return spdlog::level::err;
}

/// "<6>" and the like, as syslog(3) numbers them.
class PriorityFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& line, const std::tm&,
              spdlog::memory_buf_t& out) override {
    std::string_view priority = "<6>";
    if (line.level == spdlog::level::debug) priority = "<7>";
    if (line.level == spdlog::level::warn) priority = "<4>";
    if (line.level == spdlog::level::err) priority = "<3>";
    out.append(priority.data(), priority.data() + priority.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return spdlog::details::make_unique<PriorityFlag>();
  }
};

std::unique_ptr<spdlog::formatter> formatterFor(LogFormat format, bool priorities) {
  auto made = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  made->add_flag<PriorityFlag>('*');
  const std::string head = priorities ? "%*" : "";
  made->set_pattern(head + (format == LogFormat::kText
                                ? "%Y-%m-%dT%H:%M:%S.%eZ %^%l%$ %v"
                                : R"({"time":"%Y-%m-%dT%H:%M:%S.%fZ","level":"%l",%v})"));
  return made;
}

/// JSON is UTF-8, and what clients send need not be.
std::string dumped(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json valueOf(const LogField& field) {
  return std::visit([](const auto& value) { return json(value); }, field.value);
}

std::string jsonLine(std::string_view message, Fields fields) {
  std::string line = "\"msg\":" + dumped(message);
  for (const LogField& field : fields) {
    line += ",\"" + std::string(field.key) + "\":" + dumped(valueOf(field));
  }
  return line;
}

/// As it is where it is one plain word, else in quotes.
std::string word(const std::string& value) {
  const bool plain = !value.empty() && std::all_of(value.begin(), value.end(), [](char c) {
    return c > ' ' && c <= '~' && c != '"' && c != '\\' && c != '=';
  });
  if (plain) return value;
  std::string quoted;
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return '"' + protocol::oneLine(quoted) + '"';
}

std::string textLine(std::string_view message, Fields fields) {
  std::string line = protocol::oneLine(message);
  for (const LogField& field : fields) {
    const auto* text = std::get_if<std::string>(&field.value);
    line += " " + std::string(field.key) + "=" + (text ? word(*text) : dumped(valueOf(field)));
  }
  return line;
}

/// Whether stderr is the journal's own stream (systemd.exec(5), $JOURNAL_STREAM): not that of a
/// parent whose environment came down to us.
bool stderrIsJournal() {
  const char* named = std::getenv("JOURNAL_STREAM");
  struct stat info {};
  if (named == nullptr || ::fstat(STDERR_FILENO, &info) != 0) return false;
  return std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino) == named;
}

}  // namespace

struct Log::Impl {
  Impl(std::shared_ptr<spdlog::sinks::sink> sink, const Clock& time, bool systemd)
      : logger("culld", std::move(sink)), clock(time), priorities(systemd) {
    set({});
  }

  void set(const LogOptions& options) {
    const std::lock_guard lock(mutex);
    format = options.format;
    logger.set_level(levelOf(options.level));
    logger.set_formatter(formatterFor(format, priorities));
  }

  struct Bucket {
    std::chrono::nanoseconds filled{0};
    double room = kBurst;
    std::int64_t left_out = 0;
  };

  /// How many lines were left out before this one, or none if it is to be left out as well.
  std::optional<std::int64_t> admit(std::string_view message) {
    if (buckets.size() >= kWatchedMessages && buckets.find(message) == buckets.end()) {
      buckets.clear();
    }
    const auto now = clock.now();
    Bucket& bucket = buckets.try_emplace(std::string(message), Bucket{now}).first->second;
    const double seconds = std::chrono::duration<double>(now - bucket.filled).count();
    bucket.room = std::min(kBurst, bucket.room + seconds * kPerSecond);
    bucket.filled = now;
    if (bucket.room < 1) {
      ++bucket.left_out;
      return std::nullopt;
    }
    bucket.room -= 1;
    return std::exchange(bucket.left_out, 0);
  }

  std::mutex mutex;
  spdlog::logger logger;
  const Clock& clock;
  const bool priorities;
  LogFormat format = LogFormat::kText;
  std::map<std::string, Bucket, std::less<>> buckets;
};

Log::Log() = default;
Log::Log(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Log::Log(std::ostream& out, const Clock& clock, bool systemd_priorities)
    : impl_(std::make_unique<Impl>(std::make_shared<spdlog::sinks::ostream_sink_st>(out, true),
                                   clock, systemd_priorities)) {}
Log::~Log() = default;

std::unique_ptr<Log> Log::toStderr() {
  return std::unique_ptr<Log>(new Log(std::make_unique<Impl>(
      std::make_shared<spdlog::sinks::stderr_color_sink_st>(), steadyClock(), stderrIsJournal())));
}

void Log::set(const LogOptions& options) {
  if (impl_) impl_->set(options);
}

void Log::write(LogLevel level, std::string_view message, Fields fields) {
  if (!impl_ || !impl_->logger.should_log(levelOf(level))) return;
  const std::lock_guard lock(impl_->mutex);
  const auto left_out = impl_->admit(message);
  if (!left_out) return;
  const bool text = impl_->format == LogFormat::kText;
  std::string line = text ? textLine(message, fields) : jsonLine(message, fields);
  if (*left_out > 0) {
    line += (text ? " left_out=" : ",\"left_out\":") + std::to_string(*left_out);
  }
  impl_->logger.log(levelOf(level), line);
}

void Log::debug(std::string_view message, Fields f) { write(LogLevel::kDebug, message, f); }
void Log::info(std::string_view message, Fields f) { write(LogLevel::kInfo, message, f); }
void Log::warning(std::string_view message, Fields f) { write(LogLevel::kWarning, message, f); }
void Log::error(std::string_view message, Fields f) { write(LogLevel::kError, message, f); }

}  // namespace culld::server
