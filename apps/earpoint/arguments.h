#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <earpoint/vector3.h>

namespace earpoint {

/// Parses "1.0,-0.5,0" into exactly `count` finite numbers.
/// @param flag  names the argument in the message
/// @throws InputError
std::vector<double> parse_numbers(const std::string& text, std::size_t count,
                                  const std::string& flag);

/// Parses "x,y,z" into a place relative to the source view.
/// @throws InputError naming the flag, also where a coordinate is farther than 10 km: nobody hears
///         that far, and units are then most likely mixed up
Vector3 parse_place(const std::string& text, const std::string& flag);

/// Accepts numbers from `least` to `most`; refuses NaN, which CLI::Range accepts.
CLI::Validator within(double least, double most);

/// A texture of gtf: natural, 1, or mean, 0, or a number between. Nothing: it is none of these.
std::optional<double> texture_of(const std::string& word);

/// Accepts what texture_of() knows.
CLI::Validator known_texture();

/// --ambient KIND, a name of AmbientSeparation.
/// @param treatment  of ambient sound, as "which is removed"
/// @param cutoff     below which bandpass takes everything for it
void add_ambient_option(CLI::App& command, std::string& ambient, const char* treatment,
                        const char* cutoff);

}  // namespace earpoint
