#include <earpoint/serve/listener_registry.h>

#include <utility>

#include <earpoint/serve/clip_library.h>

namespace earpoint {
namespace {

constexpr std::chrono::seconds kSilence{60};

}  // namespace

std::string ListenerRegistry::add(std::shared_ptr<const ServedClip> clip) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(seats_, [&](const auto& entry) {
    const std::unique_lock seat(entry.second->mutex, std::try_to_lock);
    return seat.owns_lock() && now - entry.second->last_heard > kSilence;
  });
  if (seats_.size() >= most_) return {};
  std::string name = unguessable_name();
  seats_.emplace(name, std::make_shared<Seat>(std::move(clip), methods_));
  return name;
}

std::shared_ptr<ListenerRegistry::Seat> ListenerRegistry::find(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto seat = seats_.find(name);
  return seat == seats_.end() ? nullptr : seat->second;
}

void ListenerRegistry::remove(const std::string& name) {
  const std::lock_guard lock(mutex_);
  seats_.erase(name);
}

std::size_t ListenerRegistry::size() {
  const std::lock_guard lock(mutex_);
  return seats_.size();
}

}  // namespace earpoint
