#pragma once

#include "metrics_report.h"

#include <filesystem>
#include <optional>
#include <string>

#include <earpoint/evaluate/metric_convention.h>

namespace earpoint {

/// Compares two impulse responses by a convention that does.
/// @param pair  as response_pair() makes it, at the convention's rate
/// @throws InputError if they cannot be compared so
MetricsReport response_report(MetricConvention convention, const ResponsePair& pair);

/// The same for any two sounds: brings both to the convention's rate, cuts them to a length, and
/// notes what it did.
/// @param reference_name, estimate_name  stand for the two in messages and notes, e.g. their files
/// @param length_s  seconds from the beginning; nothing: compared_length_s()
MetricsReport response_report(MetricConvention convention, Waveform reference,
                              const std::string& reference_name, Waveform estimate,
                              const std::string& estimate_name, std::optional<double> length_s);

/// Compares two files of impulse responses by a convention that does.
/// @param length_s  seconds from the beginning; nothing: compared_length_s()
/// @throws InputError if a file cannot be read, or the two cannot be compared so
MetricsReport response_report(MetricConvention convention, const std::filesystem::path& reference,
                              const std::filesystem::path& estimate,
                              std::optional<double> length_s);

}  // namespace earpoint
