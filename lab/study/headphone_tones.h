#pragma once

#include <filesystem>
#include <vector>

#include <earpoint/study/study.h>

namespace earpoint {

/// Writes the sounds of the headphone check: three tones of 200 Hz and one second each, with ramps
/// of 100 ms and pauses of half a second. One is 6 dB quieter, and one of the two others in
/// opposite phase at the ears. The six trials are all ways to place them.
/// @param folder  of the study
/// Source: Woods, Siegel, Traer and McDermott, Headphone screening to facilitate web-based auditory
/// experiments, Attention, Perception & Psychophysics 79 (2017).
std::vector<HeadphoneTrial> write_headphone_trials(const std::filesystem::path& folder);

}  // namespace earpoint
