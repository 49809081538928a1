// Whose work is next: deficit round robin (Shreedhar and Varghese, 1995) between tenants, by what
// their work was measured to cost. As a cost is known only afterwards, a tenant may run into debt
// by the work it has under way, and then waits until the others have had as much.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <optional>
#include <string>

namespace culld::server {

/// THREADS: one at a time.
class FairQueue {
 public:
  struct Item {
    std::string payer;
    std::function<void()> work;
  };

  void push(std::string payer, std::function<void()> work);
  /// COST: linear in the tenants with work or debts.
  std::optional<Item> pop();
  /// What an item of `payer` took, once it is done.
  void charge(const std::string& payer, std::chrono::nanoseconds cost);
  bool empty() const noexcept { return waiting_ == 0; }
  void clear();

 private:
  struct Flow {
    std::string payer;
    std::chrono::nanoseconds deficit{0};  ///< it may run while this is above zero
    std::deque<std::function<void()>> waiting;
  };
  Flow& flowOf(const std::string& payer);
  void grant();

  std::list<Flow> flows_;  ///< the ring; the first is asked first
  std::size_t waiting_ = 0;
};

}  // namespace culld::server
