#include "tests/durability/daemon.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

namespace culld::testing {

void Daemon::launch(const Environment& environment) {
  std::vector<std::string> words{CULLD_BINARY, "serve",  "--listen",     "127.0.0.1:0", "--unix",
                                 socketPath(), "--data", data_.string(), "--threads",   "2"};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ != 0) return;
  for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
  const int log = ::open(logPath().c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(log, STDERR_FILENO);
  ::dup2(log, STDOUT_FILENO);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that ends badly leaves no daemon behind
  ::execv(argv[0], argv.data());
  ::_exit(127);
}

bool Daemon::awaitReady() {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end && alive()) {
    if (ask("GET", "/readyz").status == 200) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

bool Daemon::alive() {
  if (pid_ <= 0) return false;
  if (::waitpid(pid_, nullptr, WNOHANG) == 0) return true;
  pid_ = -1;
  return false;
}

void Daemon::kill() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

int Daemon::stop() {
  if (pid_ <= 0) return -1;
  ::kill(pid_, SIGTERM);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string Daemon::log() const {
  std::ifstream in(logPath());
  return {std::istreambuf_iterator<char>(in), {}};
}

HttpAnswer Daemon::ask(const std::string& method, const std::string& path,
                       std::string_view body) const {
  RawSocket socket = connect();
  if (!socket.connected()) return {};
  const std::string length =
      method == "PUT" ? "Content-Length: " + std::to_string(body.size()) + "\r\n" : "";
  if (!socket.send(method + " " + path + " HTTP/1.1\r\nHost: x\r\n" + length + "\r\n")) return {};
  socket.send(body);
  return readAnswer(socket);
}

}  // namespace culld::testing
