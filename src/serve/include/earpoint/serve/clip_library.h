#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <earpoint/serve/served_clip.h>

namespace earpoint {

/// The clips that a server offers. Any thread may use it.
class ClipLibrary {
 public:
  using Opener = std::function<ServedClip()>;

  /// What a page lists.
  struct Entry {
    std::string id;    ///< in addresses: letters, digits and `-`
    std::string name;  ///< for people
  };

  /// Adds a clip that is opened when somebody first wants to hear it. Of these, those that were
  /// asked for last are kept open.
  /// @param id  not there yet
  void add(const std::string& id, const std::string& name, Opener opener);

  /// Adds a clip that is there for those who know its id alone. The oldest makes room.
  /// @return its id, which nobody can guess
  [[nodiscard]] std::string add_private(ServedClip clip);

  /// All but the private ones, in the order in which they were added.
  [[nodiscard]] std::vector<Entry> list() const;

  /// @return null if there is no such clip
  /// @throws InputError as the opener
  [[nodiscard]] std::shared_ptr<const ServedClip> open(const std::string& id);

 private:
  struct Known {
    Entry entry;
    Opener opener;
  };
  struct Open {
    std::string id;
    std::shared_ptr<const ServedClip> clip;
  };
  mutable std::mutex mutex_;
  std::mutex opening_;
  std::vector<Known> known_;
  std::list<Open> open_;     ///< the last one asked for first
  std::list<Open> private_;  ///< the newest first
};

/// 128 bits from the operating system, as 32 hexadecimal digits.
[[nodiscard]] std::string unguessable_name();

}  // namespace earpoint
