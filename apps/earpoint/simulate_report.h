#pragma once

#include <string>

#include <earpoint/generate/generation_summary.h>

namespace earpoint {

/// @return what `earpoint simulate` prints at the end
std::string simulation_report(const GenerationSummary& summary);

}  // namespace earpoint
