#pragma once

#include <string>

#include <earpoint/study/study.h>

namespace earpoint {

/// The study as a configuration of webMUSHRA (audiolabs/webMUSHRA): ratings of the design mushra as
/// its mushra pages, one for each clip and scale; the design choice, of which it has only pairs, as
/// its paired_comparison pages, all pairs of a clip's methods. Its own reference is the hidden one;
/// controls and the headphone check are left out.
/// @param place  where the study's folder lies in webMUSHRA's, e.g. "configs/study"
/// @return YAML
[[nodiscard]] std::string webmushra_yaml(const Study& study, const std::string& place);

}  // namespace earpoint
