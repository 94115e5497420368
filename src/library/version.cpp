#include <earpoint/version.h>

namespace earpoint {

const char* library_version() { return EARPOINT_VERSION_TEXT; }

}  // namespace earpoint
