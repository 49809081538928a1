// `culld serve`: runs the daemon until SIGTERM or SIGINT.
#pragma once
#include <string>
#include <vector>

namespace culld {

struct ServeArguments {
  std::string listen = "127.0.0.1:7420";
  std::string unix_path;
  std::string data_folder;
  std::vector<std::string> scenes;  ///< NAME=FILE
  std::size_t threads = 0;
};

/// Returns the exit code of the program.
int runServe(const ServeArguments& arguments);

}  // namespace culld
