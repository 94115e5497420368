#pragma once

namespace earpoint {

/// The text of materials.json, which CMake builds in.
extern const char* const kStandardMaterialsJson;

}  // namespace earpoint
