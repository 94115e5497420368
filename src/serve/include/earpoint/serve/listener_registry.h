#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>

#include <earpoint/serve/listener.h>

namespace earpoint {

/// The listeners of a server: at most so many at once, and whoever is silent for a minute makes
/// room.
class ListenerRegistry {
 public:
  /// @param methods  must outlive it
  /// @param most     > 0
  ListenerRegistry(std::span<const ListenMethod> methods, std::size_t most)
      : methods_(methods), most_(most) {}

  /// @return the new listener's name, which nobody can guess; empty if there is no room
  [[nodiscard]] std::string add(std::shared_ptr<const ServedClip> clip);

  /// Keeps others away from one listener.
  struct Seat {
    Seat(std::shared_ptr<const ServedClip> clip, std::span<const ListenMethod> methods)
        : listener(std::move(clip), methods) {}
    std::mutex mutex;
    Listener listener;
    std::chrono::steady_clock::time_point last_heard = std::chrono::steady_clock::now();
  };

  /// @return null if nobody has that name (any more)
  [[nodiscard]] std::shared_ptr<Seat> find(const std::string& name);

  /// The listener has left: there is room for another.
  void remove(const std::string& name);

  [[nodiscard]] std::size_t size();

 private:
  std::span<const ListenMethod> methods_;
  std::size_t most_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Seat>> seats_;
};

}  // namespace earpoint
