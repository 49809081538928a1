// What a user of the installed SDK writes first: connect, and say what went wrong.
#include <culld/address.h>
#include <culld/connection.h>

#include <iostream>

int main() {
  const auto address = culld::client::parseAddress("ws://127.0.0.1:1");
  if (!address.ok()) return 1;
  const auto connection = culld::client::Connection::open(address.value(), "city");
  if (connection.ok()) return 1;  // nobody listens on port 1
  std::cout << "as expected: " << connection.error().message << '\n';
  return 0;
}
