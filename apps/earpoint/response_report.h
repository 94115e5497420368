#pragma once

#include "metrics_report.h"

#include <filesystem>
#include <optional>

#include <earpoint/evaluate/metric_convention.h>

namespace earpoint {

/// Compares two impulse responses by a convention that does.
/// @param pair  as response_pair() makes it, at the convention's rate
/// @throws InputError if they cannot be compared so
MetricsReport response_report(MetricConvention convention, const ResponsePair& pair);

/// Compares two files of impulse responses by a convention that does.
/// @param length_s  seconds from the beginning; nothing: compared_length_s()
/// @throws InputError if a file cannot be read, or the two cannot be compared so
MetricsReport response_report(MetricConvention convention, const std::filesystem::path& reference,
                              const std::filesystem::path& estimate,
                              std::optional<double> length_s);

}  // namespace earpoint
