#pragma once

#include "metrics_report.h"

#include <filesystem>
#include <optional>

#include <earpoint/evaluate/metric_convention.h>

/// Compares two impulse responses by a convention that does.
/// @param pair  as earpoint::response_pair() makes it, at the convention's rate
/// @throws earpoint::InputError if they cannot be compared so
MetricsReport response_report(earpoint::MetricConvention convention,
                              const earpoint::ResponsePair& pair);

/// Compares two files of impulse responses by a convention that does.
/// @param length_s  seconds from the beginning; nothing: compared_length_s()
/// @throws earpoint::InputError if a file cannot be read, or the two cannot be compared so
MetricsReport response_report(earpoint::MetricConvention convention,
                              const std::filesystem::path& reference,
                              const std::filesystem::path& estimate,
                              std::optional<double> length_s);
