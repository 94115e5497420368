#include <earpoint/serve/clip_library.h>

#include <algorithm>
#include <random>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::size_t kMostOpen = 8;
constexpr std::size_t kMostPrivate = 4;

}  // namespace

std::string unguessable_name() {
  std::random_device device;
  std::string name;
  for (int i = 0; i < 4; ++i) name += fmt::format("{:08x}", device());
  return name;
}

void ClipLibrary::add(const std::string& id, const std::string& name, Opener opener) {
  const std::lock_guard lock(mutex_);
  EARPOINT_CHECK(std::ranges::none_of(known_, [&](const Known& k) { return k.entry.id == id; }));
  known_.push_back({{id, name}, std::move(opener)});
}

std::string ClipLibrary::add_private(ServedClip clip) {
  std::string id = unguessable_name();
  const std::lock_guard lock(mutex_);
  private_.push_front({id, std::make_shared<const ServedClip>(std::move(clip))});
  if (private_.size() > kMostPrivate) private_.pop_back();
  return id;
}

std::vector<ClipLibrary::Entry> ClipLibrary::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<Entry> entries;
  for (const Known& known : known_) entries.push_back(known.entry);
  return entries;
}

std::shared_ptr<const ServedClip> ClipLibrary::open(const std::string& id) {
  const auto find_open = [&]() -> std::shared_ptr<const ServedClip> {
    const std::lock_guard lock(mutex_);
    for (const Open& clip : private_) {
      if (clip.id == id) return clip.clip;
    }
    const auto found = std::ranges::find(open_, id, &Open::id);
    if (found == open_.end()) return nullptr;
    open_.splice(open_.begin(), open_, found);
    return found->clip;
  };
  if (auto clip = find_open()) return clip;
  // One at a time, so that two requests for the same clip open it once.
  const std::lock_guard opening(opening_);
  if (auto clip = find_open()) return clip;
  Opener opener;
  {
    const std::lock_guard lock(mutex_);
    const auto known =
        std::ranges::find_if(known_, [&](const Known& k) { return k.entry.id == id; });
    if (known == known_.end()) return nullptr;
    opener = known->opener;
  }
  auto clip = std::make_shared<const ServedClip>(opener());
  const std::lock_guard lock(mutex_);
  open_.push_front({id, clip});
  if (open_.size() > kMostOpen) open_.pop_back();
  return clip;
}

}  // namespace earpoint
