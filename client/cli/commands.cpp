#include "client/cli/commands.h"

#include <iostream>

#include "protocol/text.h"

namespace culld::client {

int fail(ExitCode code, const std::string& message) {
  std::cerr << "cullctl: " << protocol::oneLine(message) << '\n';
  return code;
}

int checkStdout(int code) {
  const auto written = protocol::flushStdout();
  return written || code != kFine ? code : fail(kDisk, written.error().message);
}

int fail(const protocol::Error& error) {
  switch (error.code) {
    case protocol::ErrorCode::kInvalidInput:
    case protocol::ErrorCode::kUnsupported:
    case protocol::ErrorCode::kIo:  // a file that was to be read
      return fail(kUsage, error.message);
    case protocol::ErrorCode::kUnavailable:
      return fail(kUnreachable, error.message);
    case protocol::ErrorCode::kDeadline:
    case protocol::ErrorCode::kCancelled:
    case protocol::ErrorCode::kForbidden:
    case protocol::ErrorCode::kNotFound:
    case protocol::ErrorCode::kLimit:
      break;
  }
  return fail(kFailed, error.message);
}

}  // namespace culld::client
