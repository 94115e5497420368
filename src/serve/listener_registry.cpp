#include <random>

#include <fmt/format.h>

#include <earpoint/serve/listener_registry.h>

namespace earpoint {
namespace {

constexpr std::chrono::seconds kSilence{60};

/// 128 bits from the operating system.
std::string unguessable_name() {
  std::random_device device;
  std::string name;
  for (int i = 0; i < 4; ++i) name += fmt::format("{:08x}", device());
  return name;
}

}  // namespace

std::string ListenerRegistry::add() {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(seats_, [&](const auto& entry) {
    const std::unique_lock seat(entry.second->mutex, std::try_to_lock);
    return seat.owns_lock() && now - entry.second->last_heard > kSilence;
  });
  if (seats_.size() >= most_) return {};
  std::string name = unguessable_name();
  seats_.emplace(name, std::make_shared<Seat>(clip_));
  return name;
}

std::shared_ptr<ListenerRegistry::Seat> ListenerRegistry::find(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto seat = seats_.find(name);
  return seat == seats_.end() ? nullptr : seat->second;
}

std::size_t ListenerRegistry::size() {
  const std::lock_guard lock(mutex_);
  return seats_.size();
}

}  // namespace earpoint
