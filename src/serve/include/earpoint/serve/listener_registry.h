#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include <earpoint/serve/listener.h>

namespace earpoint {

/// The listeners of a server: at most so many at once, and whoever is silent for a minute makes
/// room.
class ListenerRegistry {
 public:
  /// @param most  > 0
  ListenerRegistry(const ServedClip& clip, std::size_t most) : clip_(clip), most_(most) {}

  /// @return the new listener's name, which nobody can guess; empty if there is no room
  [[nodiscard]] std::string add();

  /// Keeps others away from one listener.
  struct Seat {
    explicit Seat(const ServedClip& clip) : listener(clip) {}
    std::mutex mutex;
    Listener listener;
    std::chrono::steady_clock::time_point last_heard = std::chrono::steady_clock::now();
  };

  /// @return null if nobody has that name (any more)
  [[nodiscard]] std::shared_ptr<Seat> find(const std::string& name);

  [[nodiscard]] std::size_t size();

 private:
  const ServedClip& clip_;
  std::size_t most_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Seat>> seats_;
};

}  // namespace earpoint
