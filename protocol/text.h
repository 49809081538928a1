// Text for people: error lines, and what a program prints. Errors are one line each, whatever bytes
// the input that they name is made of.
#pragma once
#include <string>
#include <string_view>

#include "protocol/result.h"

namespace culld::protocol {

/// `text` with control characters spelled out (\n, \x1b), so that it stays on one line and does
/// nothing to a terminal. Other bytes are left alone, UTF-8 among them.
std::string oneLine(std::string_view text);

/// Hands what was printed so far to the operating system. ERROR: kIo, for anything printed since
/// the program began: "stdout: cannot write: No space left on device".
Result<void> flushStdout();

}  // namespace culld::protocol
