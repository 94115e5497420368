#include <earpoint/evaluate/report_html.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

constexpr std::string_view kStyle = R"(
:root { --ink: #1d2430; --soft: #667085; --line: #e4e7ec; --card: #ffffff; --page: #f6f7f9;
        --accent: #2563a8; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
       font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "Liberation Sans", sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 32px 24px 64px; }
h1 { font-size: 28px; line-height: 1.2; margin: 0 0 4px; }
h2 { font-size: 20px; margin: 40px 0 8px; }
h3 { font-size: 16px; margin: 0; }
p { margin: 6px 0; max-width: 78ch; }
.soft { color: var(--soft); }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 10px;
        padding: 16px 18px; margin: 14px 0; overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th { font-weight: 600; color: var(--soft); font-size: 13px; text-align: right;
     padding: 4px 10px; border-bottom: 2px solid var(--line); white-space: nowrap; }
td { text-align: right; padding: 7px 10px; border-bottom: 1px solid var(--line);
     white-space: nowrap; vertical-align: top; line-height: 1.35; }
th:first-child, td:first-child { text-align: left; padding-left: 2px; }
tr:last-child td { border-bottom: none; }
tr.oracle td { color: var(--soft); background: #fafbfc; }
td small { display: block; color: var(--soft); font-size: 12px; }
td.best b { color: var(--accent); }
td b { font-weight: 600; }
.dot { display: inline-block; width: 10px; height: 10px; border-radius: 3px; margin-right: 7px; }
.figures { display: grid; grid-template-columns: repeat(3, 1fr); gap: 8px 16px; }
.figures svg { width: 100%; height: auto; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 18px; font-size: 13px; margin-bottom: 8px; }
.clip-head { display: flex; flex-wrap: wrap; align-items: baseline; gap: 6px 14px;
             margin-bottom: 12px; }
.tag { background: var(--accent); color: #fff; border-radius: 99px; padding: 1px 11px;
       font-size: 13px; font-weight: 600; }
.clip { display: grid; grid-template-columns: 256px 256px minmax(0, 1fr); gap: 16px;
        align-items: start; }
.clip th, .clip td { vertical-align: middle; padding: 4px 7px; }
.picture, .map svg { width: 256px; height: 256px; display: block; border-radius: 6px; }
.caption { font-size: 12px; color: var(--soft); margin-top: 4px; }
audio { width: 176px; height: 32px; display: block; }
.plots { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 12px;
         margin-top: 16px; }
.plot { width: 100%; height: auto; display: block; border: 1px solid var(--line);
        border-radius: 6px; }
.scene { display: grid; grid-template-columns: minmax(0, 2fr) minmax(0, 1fr); gap: 20px;
         align-items: start; }
.scene h3 { margin: 16px 0 6px; }
.wide { width: 100%; height: auto; display: block; border-radius: 6px; }
.heard { display: grid; grid-template-columns: 256px minmax(0, 1fr); gap: 20px;
         align-items: start; }
.sound { display: flex; flex-wrap: wrap; align-items: center; gap: 4px 16px; padding: 9px 0;
         border-bottom: 1px solid var(--line); }
.sound:last-child { border-bottom: none; }
.sound .name { flex: 1 1 260px; }
.sound audio, .scene audio { width: 240px; }
th.group { text-align: center; }
details { margin: 12px 0; }
summary { cursor: pointer; color: var(--accent); }
@media (max-width: 1000px) {
  .figures, .plots, .clip, .scene, .heard { grid-template-columns: minmax(0, 1fr); }
}
)";

constexpr std::array<std::string_view, 7> kPalette = {"#2563a8", "#d1495b", "#2a9d6f", "#8c5fbf",
                                                      "#e08e2b", "#1aa5b8", "#b8336a"};
constexpr std::array<std::string_view, 4> kPale = {"#c9b37e", "#a9bd84", "#86b8b1", "#b9a3c9"};

std::string data_uri(std::string_view type, std::span<const std::byte> bytes) {
  return fmt::format("data:{};base64,{}", type, base64(bytes));
}

void append_little_endian(std::string& bytes, std::uint32_t value, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xFFU);
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = (group << 8U) | (k < count ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[(group >> (18 - 6 * k)) & 63U] : '=';
    }
  }
  return text;
}

std::string img_tag(const Image& image, std::string_view alt, std::string_view css_class) {
  return fmt::format("<img class=\"{}\" alt=\"{}\" src=\"{}\">", css_class, escaped(alt),
                     data_uri("image/png", encode_png(image)));
}

std::string wav_bytes(const Waveform& sound, float gain) {
  const auto channels = static_cast<std::uint32_t>(sound.channels());
  const auto rate = static_cast<std::uint32_t>(sound.sample_rate_hz());
  const auto size = static_cast<std::uint32_t>(sound.samples()) * channels * 2;
  std::string bytes = "RIFF";
  append_little_endian(bytes, 36 + size, 4);
  bytes += "WAVEfmt ";
  append_little_endian(bytes, 16, 4);
  append_little_endian(bytes, 1, 2);  // integers
  append_little_endian(bytes, channels, 2);
  append_little_endian(bytes, rate, 4);
  append_little_endian(bytes, rate * channels * 2, 4);
  append_little_endian(bytes, channels * 2, 2);
  append_little_endian(bytes, 16, 2);
  bytes += "data";
  append_little_endian(bytes, size, 4);
  for (std::ptrdiff_t n = 0; n < sound.samples(); ++n) {
    for (int c = 0; c < sound.channels(); ++c) {
      const float sample = std::clamp(gain * sound.channel(c)[n] * 32768.0F, -32768.0F, 32767.0F);
      append_little_endian(bytes, static_cast<std::uint32_t>(std::lround(sample)), 2);
    }
  }
  return bytes;
}

std::string audio_tag(const Waveform& sound, float gain) {
  const std::string bytes = wav_bytes(sound, gain);
  return fmt::format("<audio controls preload=\"metadata\" src=\"{}\"></audio>",
                     data_uri("audio/wav", std::as_bytes(std::span(bytes))));
}

std::string audio_tag(std::string_view file) {
  return fmt::format("<audio controls preload=\"metadata\" src=\"{}\"></audio>", escaped(file));
}

std::string page(std::string_view title, std::string_view body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n{}</main>\n</body>\n</"
      "html>\n",
      escaped(title), kStyle, body);
}

std::string color_of(std::size_t index, std::string_view name) {
  if (name == "input") return "#7a828e";
  if (name.starts_with("oracle-")) return std::string(kPale[index % kPale.size()]);
  return std::string(kPalette[index % kPalette.size()]);
}

}  // namespace earpoint
