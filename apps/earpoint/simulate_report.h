#pragma once

#include <string>

#include <earpoint/generate/generation_summary.h>

/// @return what `earpoint simulate` prints at the end
std::string simulation_report(const earpoint::GenerationSummary& summary);
