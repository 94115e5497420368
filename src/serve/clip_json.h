#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <earpoint/serve/listen_method.h>
#include <earpoint/serve/listener.h>
#include <earpoint/serve/served_clip.h>

namespace earpoint {

/// What a page is told of a clip.
[[nodiscard]] nlohmann::json json_of(const ServedClip& clip, std::span<const ListenMethod> methods);

/// Text that is valid UTF-8 whatever file names hold.
[[nodiscard]] std::string text_of(const nlohmann::json& document);

/// What a page asks a listener for.
struct SoundRequest {
  std::ptrdiff_t start = 0;
  std::ptrdiff_t samples = 0;
  ListenWish wish;
};

/// @throws InputError naming the field
[[nodiscard]] SoundRequest parse_sound_request(const std::string& body, const ServedClip& clip);

}  // namespace earpoint
