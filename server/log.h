// What the daemon tells its operator: one event a line on stderr, with fields, as text or as JSON.
// docs/configuration.md says what the lines look like. Never bytes that let anyone in.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "culling/core/clock.h"

namespace culld::server {

enum class LogLevel : std::uint8_t { kDebug, kInfo, kWarning, kError };
enum class LogFormat : std::uint8_t { kText, kJson };

struct LogOptions {
  LogFormat format = LogFormat::kText;
  LogLevel level = LogLevel::kInfo;  ///< what is below it is not written
};

/// A name of [a-z0-9_] and a value.
struct LogField {
  template <typename T>
  LogField(std::string_view name, const T& given) : key(name) {
    if constexpr (std::is_same_v<T, bool>) {
      value = given;
    } else if constexpr (std::is_integral_v<T>) {
      value = static_cast<std::int64_t>(given);
    } else if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<double>(given);
    } else {
      value = std::string(given);
    }
  }
  std::string_view key;
  std::variant<std::string, std::int64_t, double, bool> value;
};

/// Bytes from clients may stand in fields and messages: they are escaped, and cannot begin a line.
/// Lines of the same message beyond kBurst are written kPerSecond at most; the next one that is
/// says in `left_out` how many were not. THREADS: any.
class Log {
 public:
  static constexpr double kBurst = 100;
  static constexpr double kPerSecond = 10;

  Log();  ///< writes nothing
  /// A line that systemd will read begins with its priority, as <6> (sd-daemon(3)).
  Log(std::ostream& out, const Clock& clock, bool systemd_priorities = false);
  ~Log();
  /// To stderr, in colour where it is a terminal, with priorities where it is the journal.
  static std::unique_ptr<Log> toStderr();

  void set(const LogOptions& options);

  void debug(std::string_view message, std::initializer_list<LogField> fields = {});
  void info(std::string_view message, std::initializer_list<LogField> fields = {});
  void warning(std::string_view message, std::initializer_list<LogField> fields = {});
  void error(std::string_view message, std::initializer_list<LogField> fields = {});

 private:
  struct Impl;
  explicit Log(std::unique_ptr<Impl> impl);
  void write(LogLevel level, std::string_view message, std::initializer_list<LogField> fields);
  std::unique_ptr<Impl> impl_;
};

}  // namespace culld::server
