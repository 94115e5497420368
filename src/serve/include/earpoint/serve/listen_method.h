#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <earpoint/gtf/weights.h>

namespace earpoint {

/// One way to hear a clip from another place: a button of the page.
struct ListenMethod {
  std::string name;   ///< "input", "dsp", "gtf", ...
  std::string model;  ///< what make_synthesizer() takes
  /// Where the model is a gtf network: it then renders hop by hop, as sound that arrives live.
  std::shared_ptr<const GtfWeights> gtf{};
  /// What a page's own engine (web/engine) opens to render this method: the network's file, or of
  /// `dsp` the head that the server uses, as a head file. Null: only the server renders it.
  std::shared_ptr<const std::vector<std::byte>> engine_model{};
  bool needs_box = false;      ///< it must be told where the speaker is seen
  bool needs_speaker = false;  ///< it must be told where the speaker is, seen or known
};

/// What the page calls the sound that was truly heard at a place.
inline constexpr const char* kTruthName = "truth";

/// @param words  `input`, `dsp`, names of shipped models, or NAME=FILE of weight files
/// @throws InputError naming methods if a word is none of these or names one twice, or a file is
///         no network that renders sound
[[nodiscard]] std::vector<ListenMethod> listen_methods(std::span<const std::string> words);

/// `input`, `dsp` where the head filters are there, and every shipped model that renders a place.
[[nodiscard]] std::vector<std::string> default_listen_words();

}  // namespace earpoint
