#include "arguments.h"

#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/error.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint {

std::vector<double> parse_numbers(const std::string& text, std::size_t count,
                                  const std::string& flag) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (true) {
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) break;
    numbers.push_back(value);
    if (next == end && numbers.size() == count) return numbers;
    if (next == end || *next != ',') break;
    at = next + 1;
  }
  throw InputError(flag, fmt::format("expected {} numbers like {}, found '{}'", count,
                                     count == 2   ? "0,1"
                                     : count == 3 ? "1.0,-0.5,0"
                                                  : "0.4,0.2,0.6,0.9",
                                     text));
}

Vector3 parse_place(const std::string& text, const std::string& flag) {
  const auto xyz = parse_numbers(text, 3, flag);
  const Vector3 place{xyz[0], xyz[1], xyz[2]};
  check_place(place, flag);
  return place;
}

CLI::Validator within(double least, double most) {
  return {[least, most](std::string& text) -> std::string {
            double value = 0.0;
            if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most)
              return {};
            return fmt::format("expected a number from {:g} to {:g}, found '{}'", least, most,
                               text);
          },
          fmt::format("{:g} to {:g}", least, most)};
}

std::optional<double> texture_of(const std::string& word) {
  if (word == "mean") return 0.0;
  if (word == "natural") return 1.0;
  double texture = 0.0;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, texture);
  if (error != std::errc() || stop != end || !(texture >= 0.0 && texture <= 1.0)) return {};
  return texture;
}

CLI::Validator known_texture() {
  return {[](std::string& text) -> std::string {
            if (texture_of(text)) return {};
            return fmt::format("expected natural, mean or a number from 0 to 1, found '{}'", text);
          },
          "{natural,mean} or 0 to 1"};
}

void add_ambient_option(CLI::App& command, std::string& ambient, const char* treatment,
                        const char* cutoff) {
  const auto names = ambient_separation_names();
  command
      .add_option("--ambient", ambient,
                  fmt::format("Ambient sound, {}: bandpass, all below {}; subtract or mmse, steady "
                              "noise too, found by spectral subtraction or log-MMSE",
                              treatment, cutoff))
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->capture_default_str();
}

}  // namespace earpoint
