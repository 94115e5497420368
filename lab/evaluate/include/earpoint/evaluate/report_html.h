#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include <earpoint/image.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The text with the characters that HTML gives a meaning written as entities.
[[nodiscard]] std::string escaped(std::string_view text);

/// RFC 4648, with padding.
[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// An <img> that carries its picture with it, as PNG.
/// @param alt  what it shows, for those who do not see it
[[nodiscard]] std::string img_tag(const Image& image, std::string_view alt,
                                  std::string_view css_class);

/// The bytes of a RIFF WAV file of 16 bits.
/// @param gain  samples are multiplied by it, and clamped to [-1, 1)
[[nodiscard]] std::string wav_bytes(const Waveform& sound, float gain);

/// An <audio> player that carries its sound with it.
[[nodiscard]] std::string audio_tag(const Waveform& sound, float gain);

/// An <audio> player of a file that lies beside the page.
[[nodiscard]] std::string audio_tag(std::string_view file);

/// A page with the report's style.
/// @param title  plain text
/// @param body   HTML
[[nodiscard]] std::string page(std::string_view title, std::string_view body);

/// The colour of the truth in figures and tables.
inline constexpr std::string_view kTruthColor = "#1d2430";

/// The colour of a method in figures and tables, e.g. "#4477aa".
/// @param index   among the methods
/// @param name    `input` is grey, and oracles are pale
[[nodiscard]] std::string color_of(std::size_t index, std::string_view name);

}  // namespace earpoint
